// SPDX-License-Identifier: Apache-2.0
#include "tracking/robot_track.h"

#include "tracking/planar.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace sslv {

using Eigen::Matrix2d, Eigen::Matrix3d, Eigen::Vector2d, Eigen::Vector3d;

namespace {

/// Robots change their acceleration all the time: spectral density of white jerk noise (mm2/s5, rad2/s5), at
/// least.
constexpr double kJerk = 1e7, kTurnJerk = 2e4;
/// A manoeuvre: the variance that it adds to the acceleration (mm2/s4); the time since it began; the
/// innovations (in squares of sigmas) above which a weak or a full manoeuvre is assumed.
constexpr double kManoeuvre = 1.2e7, kManoeuvreAge_s = 0.012, kRobotSurprise = 9, kGreatSurprise = 25;
/// Variance that a push by another robot adds to the velocity (mm2/s2).
constexpr double kPush = 3e5, kPushSurprise = 60;
constexpr double kTurnManoeuvre = 1500, kTurnManoeuvreAge_s = 0.02, kTurnSurprise = 25;
constexpr double kMaxAcceleration_mm_s2 = 6500, kMaxTurnAcceleration = 80;
constexpr double kFastest_mm_s = 6000;
/// Remaining calibration errors, which vary from place to place.
constexpr double kPlaceSigmaMm = 0.05, kAngleSigma_rad = 8e-4;

/// Covariance of one axis after `passed_s` of white jerk noise, for a spectral density of 1.
Matrix3d jerk_noise(double passed_s) {
  const double d = std::abs(passed_s), d2 = d * d, d3 = d2 * d;
  Matrix3d out;
  out << d3 * d2 / 20, d2 * d2 / 8, d3 / 6,  //
      d2 * d2 / 8, d3 / 3, d2 / 2,           //
      d3 / 6, d2 / 2, d;
  return out;
}

/// Covariance due to an acceleration of variance 1 that began `age_s` ago.
Matrix3d manoeuvre_noise(double age_s) {
  const Vector3d effect(age_s * age_s / 2, age_s, 1);
  return effect * effect.transpose();
}

/// Covariance due to a velocity change of variance 1 at an unknown time within `passed_s`.
Matrix3d push_noise(double passed_s) {
  Matrix3d out;
  out << passed_s * passed_s / 3, passed_s / 2, 0, passed_s / 2, 1, 0, 0, 0, 0;
  return out;
}

Matrix3d step_of(double passed_s) {
  Matrix3d out;
  out << 1, passed_s, passed_s * passed_s / 2, 0, 1, passed_s, 0, 0, 1;
  return out;
}

/// Applies the matrix of one axis to both axes.
RobotTrack::Matrix6 of_both_axes(const Matrix3d& one) {
  RobotTrack::Matrix6 out = RobotTrack::Matrix6::Zero();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) out.block<2, 2>(2 * i, 2 * j) = one(i, j) * Matrix2d::Identity();
  }
  return out;
}

/// Radius of the gate `passed_s` after the last measurement (mm).
double reach_mm(double passed_s) {
  constexpr double kJumpMm = 20, kLongest_s = 0.1;
  return kFastest_mm_s * std::min(std::abs(passed_s), kLongest_s) + kJumpMm;
}

/// Limit of the innovation in the moving robot's likelihood: any robot may move in a way that no model
/// predicts.
constexpr double kMaxSigmas = 5;

double likelihood(const Vector2d& off, const Matrix2d& cov, double most_sigmas) {
  const double square = std::min(off.dot(cov.inverse() * off), most_sigmas * most_sigmas);
  return std::exp(-0.5 * square) / std::sqrt(cov.determinant());
}

}  // namespace

RobotTrack::RobotTrack(const RobotObservation& first) : name_(first.name) {
  begin(first);
}

void RobotTrack::begin(const RobotObservation& first) {
  state_.setZero();
  state_.head<2>() = first.place_mm;
  cov_.setZero();
  cov_.diagonal() << 1, 1, 4e6, 4e6, 9e6, 9e6;
  angle_ = {first.orientation_rad, 0, 0};
  angle_cov_.setZero();
  angle_cov_.diagonal() << 1e-6, 50, 2000;
  t_s_ = seen_s_ = first.t_s;
  sightings_ = 1;
  height_mm_ = first.height_mm;
  stands_mm_ = first.place_mm;
  stands_var_mm2_ = 1;
  stands_share_ = 0;
  innovation_sigmas_.setZero();
  elsewhere_ = 0;
  other_s_ = -1e9;
  differences_.start(first.camera, first.t_s);
}

bool RobotTrack::is_finite() const {
  // Any non-finite term makes the sum non-finite. Off-diagonal terms reach the diagonal in the next step.
  return std::isfinite(state_.sum() + cov_.trace() + angle_.sum() + angle_cov_.trace() + stands_mm_.sum() +
                       stands_var_mm2_ + stands_share_ + noise_factor_ + jerk_factor_ + t_s_ + seen_s_ +
                       stood_s_);
}

bool RobotTrack::is_sure() const {
  // Two measurements in successive images, or three.
  constexpr double kNext_s = 0.03;
  return sightings_ > 2 || (sightings_ == 2 && second_after_s_ < kNext_s);
}

bool RobotTrack::goes_on(const RobotObservation& second) const {
  constexpr double kFastest_rad_s = 45, kTurnsRad = 0.1;
  const double passed_s = second.t_s - t_s_;
  return std::abs(around(second.orientation_rad - angle_[0])) <
         kFastest_rad_s * std::abs(passed_s) + kTurnsRad;
}

void RobotTrack::predict(double t_s) {
  const double passed_s = t_s - t_s_;
  if (passed_s == 0) return;
  // F * state_ and F * cov_ * F^T, F = of_both_axes(step), without multiplying by its zeros and ones
  const double half_square = passed_s * passed_s / 2;
  state_.head<2>() += passed_s * state_.segment<2>(2) + half_square * state_.tail<2>();
  state_.segment<2>(2) += passed_s * state_.tail<2>();
  cov_.topRows<2>() += passed_s * cov_.middleRows<2>(2) + half_square * cov_.bottomRows<2>();
  cov_.middleRows<2>(2) += passed_s * cov_.bottomRows<2>();
  cov_.leftCols<2>() += passed_s * cov_.middleCols<2>(2) + half_square * cov_.rightCols<2>();
  cov_.middleCols<2>(2) += passed_s * cov_.rightCols<2>();
  cov_ += of_both_axes(jerk_factor_ * kJerk * jerk_noise(passed_s));
  const Matrix3d step = step_of(passed_s);
  angle_ = step * angle_;
  angle_cov_ = step * angle_cov_ * step.transpose() + kTurnJerk * jerk_noise(passed_s);
  t_s_ = t_s;
}

bool RobotTrack::is_now_at(const RobotObservation& sighting) {
  constexpr int kSure = 3;
  const bool is_again =
      elsewhere_ > 0 && (sighting.place_mm - elsewhere_mm_).norm() < reach_mm(sighting.t_s - elsewhere_s_);
  elsewhere_ = is_again ? elsewhere_ + 1 : 1;
  elsewhere_mm_ = sighting.place_mm;
  elsewhere_s_ = sighting.t_s;
  if (std::abs(sighting.t_s - other_s_) < kGone_s &&
      (sighting.place_mm - other_mm_).norm() < reach_mm(sighting.t_s - other_s_)) {
    other_mm_ = sighting.place_mm;
    other_s_ = sighting.t_s;
    return false;
  }
  // While the robot is still seen at its old position, the robot seen elsewhere is another robot with the
  // same id.
  constexpr double kNotHere_s = 0.05;
  return elsewhere_ >= kSure && sighting.t_s - seen_s_ > kNotHere_s;
}

/// If a robot with this id was just seen elsewhere, notes it as another robot, because this one is seen here.
void RobotTrack::is_seen_here(const RobotObservation& sighting) {
  constexpr double kLately_s = 0.05, kApartMm = 150;  // no two robots are nearer
  if (elsewhere_ > 0 && std::abs(sighting.t_s - elsewhere_s_) < kLately_s &&
      (elsewhere_mm_ - sighting.place_mm).norm() > kApartMm) {
    other_mm_ = elsewhere_mm_;
    other_s_ = elsewhere_s_;
  }
  elsewhere_ = 0;
}

RobotTrack::Step RobotTrack::last_step() const {
  Step out;
  out.t_s = t_s_;
  out.state = state_;
  out.angle = angle_;
  out.stands_mm = stands_mm_;
  out.stands_share = stands_share_;
  out.place_sigma_mm = std::sqrt(std::max(0.0, cov_.topLeftCorner<2, 2>().trace() / 2));
  return out;
}

/// Successive innovations in the same direction: the filter follows too slowly. Measurement noise alone has
/// no preferred direction.
void RobotTrack::learn_jerk(const Vector2d& innovation_sigmas) {
  constexpr double kLearns = 0.03, kUsual = 0.3, kMaxEach = 4, kMaxFactor = 100;
  const double same = std::clamp(innovation_sigmas.dot(innovation_sigmas_), -kMaxEach, kMaxEach);
  jerk_factor_ = std::clamp(jerk_factor_ * std::exp(kLearns * (same - kUsual)), 1.0, kMaxFactor);
  innovation_sigmas_ = innovation_sigmas;
}

bool RobotTrack::add(const RobotObservation& sighting, const Circumstances& now, Step* step) {
  // A second measurement that cannot follow the first one replaces it, unless both have the same time.
  constexpr double kSecond_s = 0.25, kSameTime_s = 0.03;
  const double unseen_s = sighting.t_s - seen_s_;
  const bool goes_on = sightings_ > 1 || this->goes_on(sighting);
  if (unseen_s > (sightings_ == 1 ? kSecond_s : kGone_s) || (!goes_on && unseen_s > kSameTime_s)) {
    begin(sighting);
    if (step) *step = last_step();
    return true;
  }
  if (!goes_on) return false;
  if (sightings_ == 1) second_after_s_ = std::abs(sighting.t_s - t_s_);
  const RobotTrack before = *this;
  predict(sighting.t_s);
  Vector2d off = sighting.place_mm - state_.head<2>();
  off -= differences_.take(sighting.camera, sighting.t_s, off);
  // A measurement that is nearer to the other robot with this id belongs to that robot.
  constexpr double kLately_s = 0.05;
  const bool is_other =
      sighting.t_s - other_s_ < kLately_s && (sighting.place_mm - other_mm_).norm() < off.norm();
  if (is_other || off.norm() > reach_mm(sighting.t_s - before.seen_s_)) {
    *this = before;
    if (!is_now_at(sighting) || now.stays_here) return false;
    begin(sighting);
    if (step) *step = last_step();
    return true;
  }
  is_seen_here(sighting);
  const Vector2d velocity = state_.segment<2>(2);
  const Matrix2d noise =
      noise_factor_ * (sighting.place_cov_mm2 + kPlaceSigmaMm * kPlaceSigmaMm * Matrix2d::Identity()) +
      sighting.t_sigma_s * sighting.t_sigma_s * velocity * velocity.transpose();
  Matrix2d spread = cov_.topLeftCorner<2, 2>() + noise;
  stand(sighting, noise, likelihood(off, spread, kMaxSigmas));
  const double surprise = off.dot(spread.inverse() * off);
  constexpr double kUsual = 1.7, kMost = 6, kLearns = 0.03, kMaxNoise = 400;
  noise_factor_ =
      std::clamp(noise_factor_ * (1 + kLearns * (std::min(surprise, kMost) / kUsual - 1)), 1.0, kMaxNoise);
  learn_jerk(off / std::sqrt(spread.trace() / 2));
  if (surprise > kRobotSurprise) {
    Matrix3d more = (surprise > kGreatSurprise ? 1 : 0.4) * kManoeuvre * manoeuvre_noise(kManoeuvreAge_s);
    if (now.touches && surprise > kPushSurprise)
      more += kPush * push_noise(std::abs(sighting.t_s - before.seen_s_));
    cov_ += of_both_axes(more);
    spread = cov_.topLeftCorner<2, 2>() + noise;
  }
  const Vector6 predicted = state_;
  Matrix6 back;
  if (step) back = before.cov_ * of_both_axes(step_of(t_s_ - before.t_s_)).transpose() * cov_.inverse();
  const Eigen::Matrix<double, 6, 2> gain = cov_.leftCols<2>() * spread.inverse();
  state_ += gain * off;
  cov_ -= (gain * cov_.topRows<2>()).eval();
  cov_ = (0.5 * (cov_ + cov_.transpose())).eval();
  // Limits the speed to less than the gate allows. Otherwise the track of a robot that two cameras see at
  // different places would diverge.
  constexpr double kMax_mm_s = kFastest_mm_s - 500;
  const double speed = state_.segment<2>(2).norm();
  if (speed > kMax_mm_s) state_.segment<2>(2) *= kMax_mm_s / speed;
  const double acceleration = state_.tail<2>().norm();
  if (acceleration > kMaxAcceleration_mm_s2) state_.tail<2>() *= kMaxAcceleration_mm_s2 / acceleration;
  const Vector3d predicted_angle = angle_;
  const Matrix3d angle_cov = turn(sighting);
  if (step) {
    *step = last_step();
    step->is_first = false;
    step->predicted = predicted;
    step->back = back;
    step->predicted_angle = predicted_angle;
    step->angle_back = before.angle_cov_ * step_of(t_s_ - before.t_s_).transpose() * angle_cov.inverse();
  }
  constexpr double kLearnsInterval = 0.1;
  if (sighting.t_s > seen_s_) interval_s_ += kLearnsInterval * (sighting.t_s - seen_s_ - interval_s_);
  seen_s_ = std::max(seen_s_, sighting.t_s);
  ++sightings_;
  return true;
}

void RobotTrack::stand(const RobotObservation& sighting, const Matrix2d& noise, double moving_likelihood) {
  constexpr double kCreeps_mm2_s = 0.02;           // drift of a standing robot's position
  constexpr double kStops = 0.03, kStarts = 0.02;  // transition probabilities per measurement
  // Between two images at nearly the same time, every robot seems to stand still.
  constexpr double kSameTime_s = 0.004, kFaster_mm_s = 300;
  const double passed_s = sighting.t_s - stood_s_;
  if (std::abs(passed_s) < kSameTime_s) return;
  stood_s_ = sighting.t_s;
  stands_var_mm2_ += kCreeps_mm2_s * std::max(0.0, passed_s);
  const Vector2d off = sighting.place_mm - stands_mm_;
  const Matrix2d spread = noise + stands_var_mm2_ * Matrix2d::Identity();
  const double share = stands_share_ * (1 - kStarts) + (1 - stands_share_) * kStops;
  const double stands = share * likelihood(off, spread, 1e3), moves = (1 - share) * moving_likelihood;
  stands_share_ = stands + moves > 0 ? stands / (stands + moves) : 0;
  if (stands_share_ < 0.05 ||
      state_.segment<2>(2).norm() > kFaster_mm_s) {  // the standing hypothesis restarts here
    stands_share_ = 0;
    stands_mm_ = sighting.place_mm;
    stands_var_mm2_ = noise.trace() / 2;
    return;
  }
  const double gain = stands_var_mm2_ / (stands_var_mm2_ + noise.trace() / 2);
  stands_mm_ += gain * off;
  stands_var_mm2_ *= 1 - gain;
}

Matrix3d RobotTrack::turn(const RobotObservation& sighting) {
  const double off = around(sighting.orientation_rad - angle_[0]);
  const double noise =
      std::pow(std::hypot(sighting.orientation_sigma_rad, kAngleSigma_rad), 2) * angle_noise_factor_;
  double spread = angle_cov_(0, 0) + noise;
  if (off * off > kTurnSurprise * spread) {
    angle_cov_ += kTurnManoeuvre * manoeuvre_noise(kTurnManoeuvreAge_s);
    spread = angle_cov_(0, 0) + noise;
  }
  Matrix3d expected_cov = angle_cov_;
  const Vector3d gain = angle_cov_.col(0) / spread;
  angle_ += gain * off;
  angle_[0] = around(angle_[0]);
  angle_[2] = std::clamp(angle_[2], -kMaxTurnAcceleration, kMaxTurnAcceleration);
  angle_cov_ -= (gain * angle_cov_.row(0)).eval();
  return expected_cov;
}

TrackedRobot RobotTrack::Step::robot_at(const RobotName& name, double then_s) const {
  const double passed_s = then_s - t_s;
  constexpr double kAccelerates_s = 0.05;
  const double accelerates_s = std::clamp(passed_s, -kAccelerates_s, kAccelerates_s);
  const Vector2d acceleration = state.tail<2>();
  const Vector2d velocity = state.segment<2>(2) + acceleration * accelerates_s;
  const Vector2d place = state.head<2>() + state.segment<2>(2) * passed_s +
                         acceleration * (accelerates_s * (passed_s - accelerates_s / 2));
  const double moves = 1 - stands_share;
  TrackedRobot out;
  out.name = name;
  out.place_mm = stands_share * stands_mm + moves * place;
  out.velocity_mm_s = moves * velocity;
  out.orientation_rad = around(angle[0] + angle[1] * passed_s + angle[2] * passed_s * passed_s / 2);
  out.turn_rad_s = angle[1] + angle[2] * accelerates_s;
  out.place_sigma_mm = place_sigma_mm + 0.5 * kMaxAcceleration_mm_s2 * passed_s * passed_s;
  return out;
}

double RobotTrack::unforeseen_mm(double t_s) const {
  // The last two measurements give the mean velocity between them, not the velocity at the last measurement,
  // so their interval is added. With few measurements the interval is unreliable, so it is limited to keep
  // the result small.
  constexpr double kFew_s = 0.1;
  const double passed_s = std::abs(t_s - seen_s_) + std::min(interval_s_, kFew_s);
  return 0.5 * kMaxAcceleration_mm_s2 * passed_s * passed_s;
}

TrackedRobot RobotTrack::at(double t_s) const {
  TrackedRobot out = last_step().robot_at(name_, t_s);
  // Full visibility lasts for two missed images plus the delay from the exposure to this prediction.
  constexpr double kImages = 2.5, kWay_s = 0.03;
  const double lately_s = std::min(kImages * interval_s_ + kWay_s, kGone_s / 2);
  out.visibility = std::clamp(1 - (t_s - seen_s_ - lately_s) / (kGone_s - lately_s), 0.0, 1.0);
  return out;
}

}  // namespace sslv
