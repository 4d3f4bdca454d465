// SPDX-License-Identifier: Apache-2.0
#include "tracking/ball_track.h"

#include "tracking/planar.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace sslv {

using Eigen::Matrix2d, Eigen::Vector2d, Eigen::Vector3d;

namespace {

constexpr double kKickLasts_s = 1.2;  // the kick fit is updated this long after a kick
constexpr double kNearlyMm = 111.5;   // distance between the centres of a robot and a ball touching it
constexpr double kFlatTimeSigma_s = 0.08e-3;
constexpr double kFreeSlides_mm_s2 = 3500;

}  // namespace

ShotPoint BallTrack::point_of(const BallObservation& one) {
  return {one.t_s, one.camera_mm, one.place_mm, one.sigma_mm, one.height_mm, one.height_sigma_mm};
}

BallTrack::BallTrack(const BallModel& model, const BallObservation& newest, const Vector2d& velocity_mm_s,
                     int sightings)
    : model_(model),
      seen_s_(newest.t_s),
      seen_mm_(newest.place_mm),
      sightings_(sightings),
      began_mm_(newest.place_mm) {
  roll(newest, velocity_mm_s, false, velocity_mm_s.norm());
  flat_.cov.diagonal().segment<2>(2).setConstant(1e5);
  add_point(newest);
}

void BallTrack::Flat::predict(double to_s, const BallModel& model) {
  const double passed_s = to_s - t_s;
  if (std::abs(passed_s) < 1e-7) return;
  const Vector2d way = unit_of(velocity());
  const double speed = velocity().norm(), slows = speed > 1 ? state[4] : 0;
  const double goes_s = slows > 0 && passed_s > 0 ? std::min(passed_s, speed / slows) : passed_s;
  Matrix5 step = Matrix5::Identity();
  step(0, 2) = step(1, 3) = passed_s;
  constexpr double kHasDirection_mm_s = 30;
  if (speed > kHasDirection_mm_s) {
    step.block<2, 1>(0, 4) = -0.5 * passed_s * passed_s * way;
    step.block<2, 1>(2, 4) = -passed_s * way;
  }
  state.head<2>() += velocity() * goes_s - 0.5 * slows * way * goes_s * goes_s;
  const double after = std::max(0.0, speed - slows * passed_s);
  state.segment<2>(2) = way * after;
  cov = step * cov * step.transpose();
  const double q = slides ? 3000 : 300, d = std::abs(passed_s);
  for (int i = 0; i < 2; ++i) {
    cov(i, i) += q * d * d * d / 3;
    cov(i, i + 2) += q * d * d / 2;
    cov(i + 2, i) += q * d * d / 2;
    cov(i + 2, i + 2) += q * d;
  }
  cov(4, 4) += (slides ? 1e5 : 2e3) * d;
  t_s = to_s;
  if (!slides || after >= began_mm_s * model.rolls_from_share) return;
  slides = false;
  state[4] = model.rolls_mm_s2;
  cov.row(4).setZero();
  cov.col(4).setZero();
  cov(4, 4) = 80 * 80;
  cov(2, 2) += 900;
  cov(3, 3) += 900;
}

void BallTrack::roll(const BallObservation& at, const Vector2d& velocity_mm_s, bool slides,
                     double began_mm_s) {
  phase_ = Phase::kFree;
  flat_ = {};
  flat_.t_s = at.t_s;
  flat_.state << at.place_mm, velocity_mm_s, slides ? kFreeSlides_mm_s2 : model_.rolls_mm_s2;
  flat_.cov.diagonal() << 0.3, 0.3, 3600, 3600, slides ? 300 * 300 : 80 * 80;
  flat_.slides = slides;
  flat_.began_mm_s = began_mm_s;
  held_count_ = 0;
  alone_until_s_ = 0;
  beside_.reset();
  surprises_ = 0;
  is_announced_ = left_holder_ = false;
}

Vector2d BallTrack::held_at(double t_s, const RobotTracks& robots) const {
  const auto robot = robots.at(holder_, t_s);
  return robot ? Vector2d(robot->place_mm + turned_by(held_mm_, robot->orientation_rad)) : flat_.place();
}

/// Expected measurement: the ball's position projected from the camera onto the floor plane (z = ball
/// radius).
Vector2d BallTrack::seen_from(const Vector3d& camera_mm, double t_s, const RobotTracks& robots) const {
  if (phase_ == Phase::kHeld) return held_at(t_s, robots);
  if (phase_ == Phase::kFree) {
    Flat then = flat_;
    then.predict(t_s, model_);
    return then.place();
  }
  const BallState ball = chip_.at(t_s, model_);
  const double farther = (camera_mm.z() - model_.radius_mm) / (camera_mm.z() - ball.place_mm.z());
  return camera_mm.head<2>() + (ball.place_mm.head<2>() - camera_mm.head<2>()) * farther;
}

double BallTrack::gate_mm(double t_s) const {
  const double unseen_s = t_s - seen_s_, age_s = t_s - event_s_;
  switch (phase_) {
    case Phase::kHeld: return std::clamp(3.5 * std::sqrt(held_var_mm2_) + 2, 5.0, 12.0);
    case Phase::kFlying:
      if (!is_kick_) {
        BallFlight then = flight_;
        then.predict(t_s, model_);
        constexpr double kMaxMm = 120, kSlope = 0.5;  // kSlope: maximum horizontal offset per height
        const double spread = std::max(then.cov(0, 0), then.cov(1, 1)) + kSlope * kSlope * then.cov(2, 2);
        return std::min(kMaxMm, 4.5 * std::sqrt(std::max(0.0, spread)) + 5);
      }
      return 15 + 60 * std::max(0.0, 0.12 - age_s) / 0.12 + 40 * unseen_s + (age_s > 0.35 ? 25 : 0);
    case Phase::kFree: break;
  }
  Flat then = flat_;
  then.predict(t_s, model_);
  return std::min(40.0, 4.5 * std::sqrt(std::max(then.cov(0, 0), then.cov(1, 1)) + 0.3) + 1.5);
}

BallTrack::Saw BallTrack::add(const std::vector<BallObservation>& seen, const RobotTracks& robots,
                              std::optional<BallTrack>& before) {
  if (seen.empty()) return Saw::kNothing;
  const double t_s = seen.front().t_s;
  const Vector2d expected = seen_from(seen.front().camera_mm, t_s, robots);
  const BallObservation& nearest =
      *std::min_element(seen.begin(), seen.end(), [&](const BallObservation& a, const BallObservation& b) {
        return (a.place_mm - expected).norm() < (b.place_mm - expected).norm();
      });
  const double off_mm = (nearest.place_mm - expected).norm();
  bool is_it = off_mm < gate_mm(t_s);
  // A chip that is not yet recognised deviates from the trajectory predicted on the floor.
  constexpr double kYoung_s = 0.35, kPerPeriodMm = 90, kPeriod_s = 0.0133, kMaxMm = 120;
  if (!is_it && phase_ == Phase::kFree && is_kick_ && t_s - event_s_ < kYoung_s)
    is_it = off_mm < gate_mm(t_s) + kPerPeriodMm * (t_s - seen_s_) / kPeriod_s && off_mm < kMaxMm;
  if (is_it) {
    forget_branches();
    seen_s_ = t_s;
    seen_mm_ = nearest.place_mm;
    ++sightings_;
    accept(nearest, robots);
    constexpr double kMoves_mm_s = 150, kMovedMm = 12;
    has_moved_ = has_moved_ || (nearest.place_mm - began_mm_).norm() > kMovedMm;
    if (has_moved_ && (phase_ != Phase::kFree || flat_.velocity().norm() > kMoves_mm_s)) moved_s_ = t_s;
    return Saw::kBall;
  }
  return surprise(seen, expected, robots, before);
}

bool BallTrack::explains(const BallObservation& sighting, const RobotTracks& robots) const {
  return (sighting.place_mm - seen_from(sighting.camera_mm, sighting.t_s, robots)).norm() <
         gate_mm(sighting.t_s);
}

bool BallTrack::is_gone(double t_s) const {
  // A held ball moves with its robot, so it may stay unseen longer.
  constexpr double kGone_s = 0.8, kHeldGone_s = 2;
  return t_s - seen_s_ > (phase_ == Phase::kHeld ? kHeldGone_s : kGone_s);
}

bool BallTrack::is_too_fast() const {
  constexpr double kFastest_mm_s = 9000;
  return phase_ == Phase::kFree && flat_.velocity().norm() > kFastest_mm_s;
}

bool BallTrack::is_finite() const {
  // Any non-finite term makes the sum non-finite.
  double all = seen_s_ + seen_mm_.sum() + flat_.t_s + flat_.state.sum() + flat_.cov.sum() + held_mm_.sum() +
               held_var_mm2_;
  if (phase_ == Phase::kFlying)
    all += chip_.t_s + chip_.place_mm.sum() + chip_.velocity_mm_s.sum() + flight_.state.sum() +
           flight_.cov.sum();
  return std::isfinite(all);
}

void BallTrack::correct(const BallObservation& sighting) {
  flat_.predict(sighting.t_s, model_);
  const Vector2d velocity = flat_.velocity();
  const Matrix2d noise = sighting.sigma_mm * sighting.sigma_mm * Matrix2d::Identity() +
                         kFlatTimeSigma_s * kFlatTimeSigma_s * velocity * velocity.transpose();
  const Vector2d seen_off = sighting.place_mm - flat_.place(),
                 off = seen_off - differences_.take(sighting.camera_mm, sighting.t_s, seen_off);
  Matrix2d spread = flat_.cov.topLeftCorner<2, 2>() + noise;
  const double surprise = off.dot(spread.inverse() * off);
  constexpr double kSurprise = 9;
  if (surprise > kSurprise) {
    ++surprises_;
    flat_.cov.diagonal().segment<2>(2).array() += surprise * 3000;
    flat_.cov.diagonal().head<2>().array() += surprise * 0.3;
    flat_.cov(4, 4) += 1e6;
    spread = flat_.cov.topLeftCorner<2, 2>() + noise;
  }
  const Eigen::Matrix<double, 5, 2> gain = flat_.cov.leftCols<2>() * spread.inverse();
  flat_.state += gain * off;
  flat_.cov -= (gain * flat_.cov.topRows<2>()).eval();
  flat_.cov = (0.5 * (flat_.cov + flat_.cov.transpose())).eval();
  flat_.state[4] =
      flat_.slides ? std::clamp(flat_.state[4], 2500.0, 4500.0) : std::clamp(flat_.state[4], 150.0, 500.0);
}

void BallTrack::accept(const BallObservation& sighting, const RobotTracks& robots) {
  if (phase_ == Phase::kHeld) {
    const auto robot = robots.at(holder_, sighting.t_s);
    if (!robot) return;
    const Vector2d away = sighting.place_mm - robot->place_mm;
    const Vector2d off = turned_by(away, -robot->orientation_rad) - held_mm_;
    // The dribbler shakes the ball faster than the filter can follow.
    constexpr double kSlow = 0.1;
    const double gain = std::max(kSlow, 1.0 / ++held_count_);
    held_mm_ += gain * off;
    constexpr double kMaxVars = 6;  // larger deviations are not shaking: clip them
    held_var_mm2_ += kSlow * (std::min(off.squaredNorm(), kMaxVars * held_var_mm2_) - held_var_mm2_);
    held_seen_ = sighting;
    is_announced_ = false;
    constexpr double kLetGoMm = 150;
    if (away.norm() > kLetGoMm) roll(sighting, robot->velocity_mm_s, false, robot->velocity_mm_s.norm());
    return;
  }
  const double age_s = sighting.t_s - event_s_;
  // Floors differ in how the ball bounces, so the fit ends when the ball lands.
  constexpr double kBefore_s = 1e-3;
  if (phase_ == Phase::kFlying && is_kick_) {
    const double lands_s = chip_.t_s + chip_.lands_after_s() - kBefore_s;
    if (sighting.t_s > lands_s || age_s >= kKickLasts_s) {
      flight_ = flight_at(std::min(sighting.t_s, lands_s));
      is_kick_ = false;
    }
  }
  if (phase_ == Phase::kFree) correct(sighting);
  if (is_kick_ && age_s < kKickLasts_s) {
    add_point(sighting);
    fit_shot();
  }
  if (phase_ == Phase::kFlying && !is_kick_) {
    flight_.correct(point_of(sighting), model_);
    if (flight_.is_over || flight_.is_doubtful() || flight_.is_impossible(model_)) {
      const Vector2d velocity = flight_.state.segment<2>(3);
      roll(sighting, velocity, false, velocity.norm());
      flat_.cov.diagonal().segment<2>(2).setConstant(4e4);
    } else {
      chip_ = flight_.shot(model_);
    }
  }
  if (phase_ == Phase::kFree && !is_kick_) {
    add_point(sighting);
    may_fly(sighting.t_s, robots);
  }
  may_be_held(sighting, robots);
}

void BallTrack::may_be_held(const BallObservation& sighting, const RobotTracks& robots) {
  if (phase_ != Phase::kFree) return;
  constexpr double kNearMm = 125, kFrontRad = 0.6, kSlow_mm_s = 500, kAfterEvent_s = 0.06;
  constexpr int kSure = 3;
  if (sighting.t_s < alone_until_s_) return;
  const auto near = robots.nearest(flat_.place(), sighting.t_s);
  // No robot can reach the ball before alone_until_s_.
  constexpr double kRobots_mm_s = 6000;
  if (near && near->distance_mm > kNearMm)
    alone_until_s_ = sighting.t_s + (near->distance_mm - kNearMm) / (kRobots_mm_s + flat_.velocity().norm());
  constexpr double kBesideMm = 135;
  beside_.reset();
  if (near && near->distance_mm < kBesideMm)
    beside_ = {near->robot.name,
               turned_by(flat_.place() - near->robot.place_mm, -near->robot.orientation_rad)};
  if (!near || near->distance_mm >= kNearMm || near->from_front_rad >= kFrontRad) {
    held_count_ = 0;
    return;
  }
  const Vector2d away = sighting.place_mm - near->robot.place_mm;
  const Vector2d relative =
      flat_.velocity() - near->robot.velocity_mm_s - left_of(away) * near->robot.turn_rad_s;
  if (relative.norm() >= kSlow_mm_s || sighting.t_s - event_s_ <= kAfterEvent_s) {
    held_count_ = 0;
    return;
  }
  if (++held_count_ < kSure) return;
  phase_ = Phase::kHeld;
  held_count_ = 1;
  held_seen_ = sighting;
  constexpr double kShakesMm = 2;
  held_var_mm2_ = kShakesMm * kShakesMm;
  holder_ = near->robot.name;
  held_mm_ = turned_by(away, -near->robot.orientation_rad);
  is_kick_ = false;
}

/// Flight filter initialised from chip_ at `t_s`, with a fixed covariance.
BallFlight BallTrack::flight_at(double t_s) const {
  constexpr double kPlaceSigmaMm = 20, kVelocitySigma_mm_s = 100;
  const BallState then = chip_.at(t_s, model_);
  BallFlight out;
  out.t_s = t_s;
  out.state << then.place_mm, then.velocity_mm_s;
  out.cov.diagonal() << BallFlight::Vector6::Constant(kVelocitySigma_mm_s * kVelocitySigma_mm_s);
  out.cov.diagonal().head<3>().setConstant(kPlaceSigmaMm * kPlaceSigmaMm);
  out.has_hopped = chip_.has_hopped || t_s > chip_.t_s + chip_.lands_after_s();
  out.is_over = then.velocity_mm_s.z() == 0;
  return out;
}

bool BallTrack::is_in_the_air(double t_s) const {
  constexpr double kInTheAirMm = 60;
  return phase_ == Phase::kFlying && chip_.at(t_s, model_).place_mm.z() > model_.radius_mm + kInTheAirMm;
}

bool BallTrack::bounces(double t_s) const {
  constexpr double kFast_mm_s = 700;
  return phase_ == Phase::kFlying && std::abs(chip_.at(t_s, model_).velocity_mm_s.z()) > kFast_mm_s;
}

void BallTrack::fly(const BallFlight& flight) {
  phase_ = Phase::kFlying;
  is_kick_ = false;
  flight_ = flight;
  chip_ = flight_.shot(model_);
  event_mm_ = chip_.place_mm;
}

/// A ball whose kick was not seen may be in the air. Tests this if the ball's apparent size or repeated large
/// innovations suggest a flight. If the test confirms it, switches to Phase::kFlying.
void BallTrack::may_fly(double t_s, const RobotTracks& robots) {
  constexpr double kLongest_s = 0.6, kSurelySigmas = 2.5;
  constexpr int kSurprises = 2;
  if (point_count_ == 0 || point_count_ == points_.size() || t_s - points_[0].t_s > kLongest_s) return;
  const std::span<const ShotPoint> points(points_.data(), point_count_);
  double sigmas = 0;
  for (const ShotPoint& point : points)
    sigmas += (point.height_mm - model_.radius_mm) / point.height_sigma_mm;
  if (sigmas < kSurelySigmas * std::sqrt(static_cast<double>(point_count_)) && surprises_ < kSurprises)
    return;
  const auto flight = find_flight(points, model_);
  if (!flight) return;
  // A held ball leaves the floor only if its holder kicks it.
  const auto kicker = left_holder_ ? robots.at(holder_, event_s_) : std::nullopt;
  if (kicker) {
    const auto before = kick_;
    begin_kick(*kicker, flight->state.segment<2>(3), true);
    if (is_chip_) return;
    kick_ = before;
  }
  fly(*flight);
}

void BallTrack::add_point(const BallObservation& sighting) {
  if (point_count_ < points_.size()) points_[point_count_++] = point_of(sighting);
}

void BallTrack::fit_shot() {
  const std::size_t count = point_count_;
  const std::span<const ShotPoint> points(points_.data(), count);
  constexpr std::size_t kFewest = 3, kOften = 16;
  if (count < kFewest || (count > kOften && count % 2) || count >= kMaxShotPoints) return;
  const double age_s = points.back().t_s - event_s_;
  ShotFit guess;
  guess.shot = {event_s_, event_mm_, kick_->velocity_mm_s};
  guess.shot.velocity_mm_s.z() = 0;
  guess.slides_mm_s2 = kFreeSlides_mm_s2;
  BallModel slides = model_;
  slides.slides_mm_s2 = kFreeSlides_mm_s2;
  ShotPrior prior;
  prior.robot = kicker_;
  const ShotFit flat = fit_flat(guess, points, slides, prior);
  const Vector2d flat_velocity = flat.shot.velocity_mm_s.head<2>();
  const double speed = flat_velocity.norm();

  ShotFit chip_guess;
  chip_guess.shot =
      is_chip_
          ? chip_
          : BallShot{event_s_, event_mm_, {0.9 * flat_velocity.x(), 0.9 * flat_velocity.y(), 0.8 * speed}};
  chip_guess.shot.t_s = event_s_;
  chip_guess.shot.place_mm = event_mm_;
  const ShotFit chip = fit_chip(chip_guess, points, model_, prior, count < 8 ? 6 : 3);
  // A ball that was deflected fits neither model.
  constexpr double kMaxEach = 6, kMost = 20;
  const bool fits = chip.chi2 < kMaxEach * static_cast<double>(count) + kMost;
  is_chip_ = fits && flat.chi2 - chip.chi2 > (is_chip_ ? -5 : 14);
  chip_ = chip.shot;
  kick_->is_chip = is_chip_;
  if (is_chip_) {
    phase_ = Phase::kFlying;
    kick_->t_s = chip.shot.t_s;
    kick_->velocity_mm_s = chip.shot.velocity_mm_s;
    kick_->landing_mm = chip.shot.landing_mm();
    return;
  }
  if (phase_ == Phase::kFlying) {
    const ShotPoint& last = points.back();
    roll({last.t_s, last.camera_mm, last.place_mm, last.sigma_mm, last.height_mm, last.height_sigma_mm},
         flat_velocity, true, speed);
  }
  // The kick took place where the fitted trajectory meets the previous one. Contact began earlier: the
  // kicker pushes for kPushes_s.
  const Vector2d way = unit_of(flat_velocity);
  constexpr double kMax_s = 0.01, kPushes_s = 0.002;
  const double faster = std::max(300.0, speed - before_mm_s_.dot(way));
  const double late_s = std::clamp((event_mm_ - flat.shot.place_mm).dot(way) / faster, -kMax_s, kMax_s);
  kick_->t_s = event_s_ + late_s - kPushes_s / 2;
  kick_->place_mm = flat.shot.place_mm + way * (speed * late_s) - before_mm_s_ * (kPushes_s / 2);
  const Vector2d kicked = flat_velocity - way * (flat.slides_mm_s2 * late_s);
  kick_->velocity_mm_s << kicked, 0;
  constexpr double kYoung_s = 0.25;
  constexpr std::size_t kFewPoints = 14;
  if (age_s >= kYoung_s || count > kFewPoints) return;
  const double now = std::max(0.0, speed - flat.slides_mm_s2 * (points.back().t_s - event_s_));
  if (now <= speed * model_.rolls_from_share) return;
  flat_.began_mm_s = speed;
  flat_.slides = true;
}

TrackedBall BallTrack::at(double t_s, const RobotTracks& robots) const {
  constexpr double kShown_s = 0.8;
  TrackedBall out;
  const Branch* branch = reappears(t_s, robots);
  BallState ball{};
  if (branch && where_it_reappears(*branch, t_s, ball)) {
    constexpr double kUnsure = 0.5;
    out.place_mm = ball.place_mm;
    out.velocity_mm_s = ball.velocity_mm_s;
    out.visibility = kUnsure;
    return out;
  }
  out.visibility = std::clamp(1 - (t_s - seen_s_ - 0.03) / kShown_s, 0.0, 1.0);
  if (phase_ == Phase::kFlying) {
    ball = chip_.at(t_s, model_);
    out.place_mm = ball.place_mm;
    out.velocity_mm_s = ball.velocity_mm_s;
    return out;
  }
  Vector2d place, velocity;
  if (phase_ == Phase::kHeld) {
    place = held_at(t_s, robots);
    velocity = Vector2d(0, 0);
    if (const auto robot = robots.at(holder_, t_s))
      velocity = robot->velocity_mm_s + left_of(place - robot->place_mm) * robot->turn_rad_s;
  } else {
    Flat then = flat_;
    then.predict(t_s, model_);
    place = then.place();
    velocity = then.velocity();
    constexpr double kHidden_s = 0.03;
    const auto hides = beside_ && t_s - seen_s_ > kHidden_s ? robots.at(beside_->robot, t_s) : std::nullopt;
    if (hides) {
      place = hides->place_mm + turned_by(beside_->offset_mm, hides->orientation_rad);
      velocity = hides->velocity_mm_s + left_of(place - hides->place_mm) * hides->turn_rad_s;
    }
    const Vector2d from = flat_.place(), way = unit_of(place - from);
    const double length = (place - from).norm();
    for (const auto& [name, track] : robots.tracks) {
      if (hides || t_s - seen_s_ <= kHidden_s) break;
      const auto robot = robots.at(name, t_s);
      if (!robot || (from - robot->place_mm).norm() <= kNearlyMm + 0.5) continue;
      // Assume that an unseen ball has stopped at a robot in its path.
      const double nearest = std::clamp((robot->place_mm - from).dot(way), 0.0, length);
      if (nearest <= 1 || (from + way * nearest - robot->place_mm).norm() >= kNearlyMm - 6.5) continue;
      place = robot->place_mm + unit_of(from - robot->place_mm) * kNearlyMm;
      velocity = robot->velocity_mm_s;
      break;
    }
  }
  out.place_mm << place, model_.radius_mm;
  out.velocity_mm_s << velocity, 0;
  return out;
}

}  // namespace sslv
