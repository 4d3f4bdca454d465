// SPDX-License-Identifier: Apache-2.0
#include "tracking/ball_flight.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace sslv {

using Eigen::Vector2d, Eigen::Vector3d;
using Vector6 = BallFlight::Vector6;
using Matrix6 = BallFlight::Matrix6;

namespace {

/// Disagreement of the cameras' floor planes, and timestamp uncertainty.
constexpr double kFloorSigmaMm = 1, kTimeSigma_s = 0.1e-3;

constexpr double kForgets = 0.8;  // decay of lower_sigmas per measurement

double variance_of(const ShotPoint& point, double speed_mm_s) {
  return point.sigma_mm * point.sigma_mm + kFloorSigmaMm * kFloorSigmaMm +
         std::pow(kTimeSigma_s * speed_mm_s, 2);
}

/// Line of sight: the ball is on the line place_mm + slope * (height above the floor).
struct Sight {
  Vector2d slope;
  explicit Sight(const ShotPoint& point, double radius_mm)
      : slope((point.camera_mm.head<2>() - point.place_mm) / (point.camera_mm.z() - radius_mm)) {}
};

/// Weighted least squares of six parameters, accumulated one equation at a time.
struct Squares {
  Matrix6 information = Matrix6::Zero();
  Vector6 right = Vector6::Zero();
  double constant = 0;

  void add(const Vector6& row, double value, double variance) {
    information += row * row.transpose() / variance;
    right += row * (value / variance);
    constant += value * value / variance;
  }
};

}  // namespace

void BallFlight::hop(const BallModel& model) {
  const double along = has_hopped ? model.later_hops_xy : model.first_hop_xy;
  // Relative uncertainty of a bounce: floors differ.
  constexpr double kAlongSigma = 0.2, kUpSigma = 0.1;
  Vector6 damps;
  damps << 1, 1, 0, along, along, -model.hops_z;
  const double speed = state.segment<2>(3).norm(), down = state[5];
  state = damps.cwiseProduct(state);
  state[2] = model.radius_mm;
  // The height is known at the bounce. A height error before the bounce shifts the landing time and the
  // rebound speed.
  cov = damps.asDiagonal() * cov * damps.asDiagonal();
  cov(2, 2) += 4;
  cov(3, 3) += std::pow(kAlongSigma * speed, 2);
  cov(4, 4) += std::pow(kAlongSigma * speed, 2);
  cov(5, 5) += std::pow(kUpSigma * down, 2);
  has_hopped = true;
  if (state[5] >= BallShot::kLastHop_mm_s) return;
  state[5] = 0;
  is_over = true;
}

double BallFlight::lands_after_s(const BallModel& model) const {
  const double up = state[5], over_mm = std::max(0.0, state[2] - model.radius_mm);
  return (up + std::sqrt(up * up + 2 * kGravity_mm_s2 * over_mm)) / kGravity_mm_s2;
}

void BallFlight::predict(double to_s, const BallModel& model) {
  double left_s = to_s - t_s;
  constexpr int kMaxHops = 5;
  for (int i = 0; i < kMaxHops && !is_over; ++i) {
    const double lands_s = lands_after_s(model);
    const bool lands = left_s > 0 && lands_s <= left_s;
    const double step_s = lands ? lands_s : left_s;
    state.head<3>() += state.tail<3>() * step_s;
    state[2] -= 0.5 * kGravity_mm_s2 * step_s * step_s;
    state[5] -= kGravity_mm_s2 * step_s;
    Matrix6 step = Matrix6::Identity();
    step(0, 3) = step(1, 4) = step(2, 5) = step_s;
    cov = (step * cov * step.transpose()).eval();
    constexpr double kNoise_mm2_s3 = 2000;
    cov.diagonal().tail<3>().array() += kNoise_mm2_s3 * std::abs(step_s);
    left_s -= step_s;
    if (!lands) break;
    hop(model);
  }
  if (is_over) state.head<2>() += state.segment<2>(3) * left_s;
  t_s = to_s;
}

void BallFlight::correct(const ShotPoint& seen, const BallModel& model) {
  predict(seen.t_s, model);
  const Vector2d slope = Sight(seen, model.radius_mm).slope;
  const double variance = variance_of(seen, state.segment<2>(3).norm());
  double innovation = 0;
  const auto update = [&](const Vector6& row, double value, double noise) {
    const Vector6 along = cov * row;
    const double spread = row.dot(along) + noise, off = value - row.dot(state);
    innovation += off * off / spread;
    state += along * (off / spread);
    cov -= (along * along.transpose() / spread).eval();
  };
  for (int axis = 0; axis < 2; ++axis) {
    Vector6 row = Vector6::Zero();
    row[axis] = 1;
    row[2] = -slope[axis];
    update(row, seen.place_mm[axis] - slope[axis] * model.radius_mm, variance);
  }
  // The ball bounces sooner than predicted.
  constexpr double kFollows = 0.4, kMaxEach = 30, kSurprise = 10, kSoon_s = 0.06;
  surprise += kFollows * (std::min(innovation, kMaxEach) - surprise);
  if (surprise > kSurprise && state[5] < 0 && lands_after_s(model) < kSoon_s) {
    hop(model);
    surprise = kUsualSurprise;
  }
  if (std::isfinite(seen.height_sigma_mm)) {
    Vector6 row = Vector6::Zero();
    row[2] = 1;
    const double noise = seen.height_sigma_mm * seen.height_sigma_mm;
    lower_sigmas = kForgets * lower_sigmas + (state[2] - seen.height_mm) / std::sqrt(cov(2, 2) + noise);
    update(row, seen.height_mm, noise);
  }
  state[2] = std::max(state[2], model.radius_mm);
}

bool BallFlight::is_doubtful() const {
  constexpr double kSigmas = 4;
  return lower_sigmas > kSigmas / std::sqrt(1 - kForgets * kForgets);
}

double BallFlight::rose_mm_s(const BallModel& model) const {
  return std::hypot(state[5], std::sqrt(2 * kGravity_mm_s2 * std::max(0.0, state[2] - model.radius_mm)));
}

bool BallFlight::is_impossible(const BallModel& model) const {
  constexpr double kFastest_mm_s = 7500;
  return std::hypot(state.segment<2>(3).norm(), rose_mm_s(model)) > kFastest_mm_s;
}

void BallFlight::turn(double place_sigma_mm) {
  constexpr double kVelocitySigma_mm_s = 4000;
  for (int i : {0, 1, 3, 4}) {
    cov.row(i).setZero();
    cov.col(i).setZero();
    cov(i, i) = std::pow(i < 2 ? place_sigma_mm : kVelocitySigma_mm_s, 2);
  }
}

BallShot BallFlight::shot(const BallModel& model) const {
  return {t_s, state.head<2>(), state.tail<3>(), std::max(0.0, state[2] - model.radius_mm), has_hopped};
}

std::optional<BallFlight> find_flight(std::span<const ShotPoint> points, const BallModel& model) {
  constexpr std::size_t kFewest = 4;
  constexpr double kShortest_s = 0.03;
  if (points.size() < kFewest) return {};
  const ShotPoint &first = points.front(), &last = points.back();
  const double lasts_s = last.t_s - first.t_s;
  if (lasts_s < kShortest_s) return {};
  const Vector2d velocity = (last.place_mm - first.place_mm) / lasts_s;
  const double speed = velocity.norm();
  const Vector2d way = speed > 1 ? Vector2d(velocity / speed) : Vector2d(1, 0);
  // Positions and times are relative to the last point, to keep numbers small.
  const Vector2d from = last.place_mm;
  Squares air, floor;  // air: 3D position, velocity; floor: 2D position, velocity, acceleration
  for (const ShotPoint& point : points) {
    const double t = point.t_s - last.t_s, falls = -0.5 * kGravity_mm_s2 * t * t;
    const Vector2d slope = Sight(point, model.radius_mm).slope;
    const double variance = variance_of(point, speed);
    for (int axis = 0; axis < 2; ++axis) {
      Vector6 in_air = Vector6::Zero(), on_floor = Vector6::Zero();
      in_air[axis] = 1;
      in_air[2] = -slope[axis];
      in_air[3 + axis] = t;
      in_air[5] = -slope[axis] * t;
      const double place = point.place_mm[axis] - from[axis];
      air.add(in_air, place + slope[axis] * falls, variance);
      on_floor[axis] = 1;
      on_floor[2 + axis] = t;
      on_floor[4 + axis] = 0.5 * t * t;
      floor.add(on_floor, place, variance);
    }
    if (!std::isfinite(point.height_sigma_mm)) continue;
    const double height = point.height_mm - model.radius_mm,
                 height_variance = point.height_sigma_mm * point.height_sigma_mm;
    Vector6 in_air = Vector6::Zero();
    in_air[2] = 1;
    in_air[5] = t;
    air.add(in_air, height - falls, height_variance);
    floor.constant += height * height / height_variance;
  }
  // Priors: height and vertical speed in the air; deceleration and sideways acceleration on the floor.
  constexpr double kHighSigmaMm = 600, kUpSigma_mm_s = 3000, kSlowsSigma_mm_s2 = 1800,
                   kBendsSigma_mm_s2 = 300;
  air.add(Vector6::Unit(2), 0, kHighSigmaMm * kHighSigmaMm);
  air.add(Vector6::Unit(5), 0, kUpSigma_mm_s * kUpSigma_mm_s);
  Vector6 slows = Vector6::Zero(), bends = Vector6::Zero();
  slows.tail<2>() = way;
  bends.tail<2>() << -way.y(), way.x();
  floor.add(slows, -kSlowsSigma_mm_s2, kSlowsSigma_mm_s2 * kSlowsSigma_mm_s2);
  floor.add(bends, 0, kBendsSigma_mm_s2 * kBendsSigma_mm_s2);

  const Eigen::LDLT<Matrix6> in_air(air.information), on_floor(floor.information);
  const Vector6 flies = in_air.solve(air.right), rolls = on_floor.solve(floor.right);
  const double air_chi2 = air.constant - air.right.dot(flies),
               floor_chi2 = floor.constant - floor.right.dot(rolls);
  constexpr double kSurer = 20, kLowestMm = 30, kSigmas = 3;
  // A ball that was deflected fits neither model.
  constexpr double kMaxEach = 6;
  BallFlight out;
  out.cov = in_air.solve(Matrix6::Identity());
  const bool is_high = flies[2] > kLowestMm && flies[2] * flies[2] > kSigmas * kSigmas * out.cov(2, 2);
  const bool fits = air_chi2 < kSurer + kMaxEach * static_cast<double>(points.size());
  if (floor_chi2 - air_chi2 < kSurer || !is_high || !fits) return {};
  out.t_s = last.t_s;
  out.state = flies;
  out.state.head<2>() += from;
  out.state[2] += model.radius_mm;
  // No robot kicks straight up.
  constexpr double kSteepest = 3;
  if (out.is_impossible(model) || out.rose_mm_s(model) > kSteepest * out.state.segment<2>(3).norm())
    return {};
  return out;
}

}  // namespace sslv
