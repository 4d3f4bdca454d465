// SPDX-License-Identifier: Apache-2.0
#include "tracking/kick_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>

namespace sslv {

using Eigen::Vector2d, Eigen::Vector3d;

namespace {

constexpr std::size_t kMaxResiduals = 3 * kMaxShotPoints + 8;
/// Timestamp uncertainty of a measurement.
constexpr double kShotTimeSigma_s = 0.1e-3;
constexpr double kFastestShot_mm_s = 7200, kSlowestRise_mm_s = 50;

/// Levenberg-Marquardt over N parameters. `residuals` fills an array and returns the number of values
/// written; `bound` limits the parameters. Returns the sum of squared residuals.
template <int N, class Residuals, class Bound>
double fit(Eigen::Matrix<double, N, 1>& parameters, const Eigen::Matrix<double, N, 1>& steps, int iterations,
           const Residuals& residuals, const Bound& bound) {
  using Vector = Eigen::Matrix<double, N, 1>;
  std::array<double, kMaxResiduals> here, there;
  std::array<std::array<double, kMaxResiduals>, N> slopes;
  const std::size_t count = residuals(parameters, here);
  const auto squares = [&](const auto& all) {
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) sum += all[i] * all[i];
    return sum;
  };
  double best = squares(here), damping = 1e-3;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    for (int j = 0; j < N; ++j) {
      Vector moved = parameters;
      moved[j] += steps[j];
      residuals(moved, there);
      for (std::size_t i = 0; i < count; ++i)
        slopes[static_cast<std::size_t>(j)][i] = (there[i] - here[i]) / steps[j];
    }
    Eigen::Matrix<double, N, N> normal;
    Vector down;
    for (int j = 0; j < N; ++j) {
      const auto& a = slopes[static_cast<std::size_t>(j)];
      down[j] = 0;
      for (std::size_t i = 0; i < count; ++i) down[j] -= a[i] * here[i];
      for (int k = 0; k <= j; ++k) {
        double sum = 0;
        for (std::size_t i = 0; i < count; ++i) sum += a[i] * slopes[static_cast<std::size_t>(k)][i];
        normal(j, k) = normal(k, j) = sum;
      }
    }
    normal.diagonal() *= 1 + damping;
    normal.diagonal().array() += 1e-12;
    Vector next = parameters + normal.ldlt().solve(down);
    bound(next);
    residuals(next, there);
    const double now = squares(there);
    if (now < best) {
      const bool is_done = best - now < 1e-3;
      parameters = next;
      here = there;
      best = now;
      damping *= 0.2;
      if (is_done) break;
    } else {
      damping *= 10;
      if (damping > 1e4) break;
    }
  }
  return best;
}

double sigma_of(const ShotPoint& point, double speed_mm_s) {
  return std::hypot(point.sigma_mm, kShotTimeSigma_s * speed_mm_s);
}

}  // namespace

ShotFit fit_flat(const ShotFit& guess, std::span<const ShotPoint> points, const BallModel& model,
                 const ShotPrior& prior) {
  using Vector5 = Eigen::Matrix<double, 5, 1>;
  points = points.first(std::min(points.size(), kMaxShotPoints));
  Vector5 at;
  at << guess.shot.place_mm, guess.shot.velocity_mm_s.head<2>(), guess.slides_mm_s2;
  const auto residuals = [&](const Vector5& x, std::array<double, kMaxResiduals>& out) {
    const double speed = x.segment<2>(2).norm();
    const Vector2d way = speed > 1e-9 ? Vector2d(x.segment<2>(2) / speed) : Vector2d(0, 0);
    BallModel slides = model;
    slides.slides_mm_s2 = std::max(1.0, x[4]);
    std::size_t count = 0;
    for (const ShotPoint& point : points) {
      const FlatWay gone = flat_way(speed, point.t_s - guess.shot.t_s, slides);
      const Vector2d off = x.head<2>() + way * gone.way_mm - point.place_mm;
      const double sigma = sigma_of(point, gone.speed_mm_s);
      out[count++] = off.x() / sigma;
      out[count++] = off.y() / sigma;
      out[count++] = (model.radius_mm - point.height_mm) / point.height_sigma_mm;
    }
    out[count++] = (x[4] - model.slides_mm_s2) / prior.slides_sigma_mm_s2;
    return count;
  };
  Vector5 steps;
  steps << 0.1, 0.1, 1, 1, 1;
  ShotFit out;
  out.chi2 = fit<5>(at, steps, 5, residuals, [](Vector5&) {});
  out.shot.t_s = guess.shot.t_s;
  out.shot.place_mm = at.head<2>();
  out.shot.velocity_mm_s << at.segment<2>(2), 0;
  out.slides_mm_s2 = at[4];
  return out;
}

ShotFit fit_chip(const ShotFit& guess, std::span<const ShotPoint> points, const BallModel& model,
                 const ShotPrior& prior, int iterations) {
  using Unknowns = Eigen::Matrix<double, 6, 1>;
  points = points.first(std::min(points.size(), kMaxShotPoints));
  Unknowns at;
  at << guess.shot.place_mm, guess.shot.velocity_mm_s, 0;
  const auto shot_of = [&](const Unknowns& x) {
    return BallShot{guess.shot.t_s + x[5], x.head<2>(), x.segment<3>(2)};
  };
  const auto residuals = [&](const Unknowns& x, std::array<double, kMaxResiduals>& out) {
    const BallShot shot = shot_of(x);
    std::size_t count = 0;
    for (const ShotPoint& point : points) {
      const BallState ball = shot.at(point.t_s, model);
      const double farther =
          (point.camera_mm.z() - model.radius_mm) / (point.camera_mm.z() - ball.place_mm.z());
      const Vector2d below = point.camera_mm.head<2>();
      const Vector2d off = below + (ball.place_mm.head<2>() - below) * farther - point.place_mm;
      const double sigma = sigma_of(point, ball.velocity_mm_s.head<2>().norm());
      out[count++] = off.x() / sigma;
      out[count++] = off.y() / sigma;
      out[count++] = (ball.place_mm.z() - point.height_mm) / point.height_sigma_mm;
    }
    const Vector2d flat = shot.velocity_mm_s.head<2>();
    out[count++] = (x[0] - guess.shot.place_mm.x()) / prior.place_sigma_mm;
    out[count++] = (x[1] - guess.shot.place_mm.y()) / prior.place_sigma_mm;
    out[count++] = x[5] / prior.t_sigma_s;
    // A kicker's angles are fixed in the robot's frame. The ball keeps part of the robot's velocity (kKeeps).
    constexpr double kKeeps = 0.5, kKeepsSigma = 0.25, kAheadSigma_rad = 0.05;
    const Vector2d robot = prior.robot ? prior.robot->velocity_mm_s : Vector2d(0, 0);
    const Vector2d kicked = flat - kKeeps * robot;
    const double rises_deg = std::atan2(shot.velocity_mm_s.z(), kicked.norm()) * 180 / std::numbers::pi;
    out[count++] = (rises_deg - prior.rises_deg) / prior.rises_sigma_deg;
    if (prior.robot) {
      const Vector2d& ahead = prior.robot->ahead;
      const double aside = ahead.x() * kicked.y() - ahead.y() * kicked.x(),
                   drifts = ahead.x() * robot.y() - ahead.y() * robot.x();
      out[count++] = aside / std::hypot(kAheadSigma_rad * flat.norm(), kKeepsSigma * drifts);
    }
    return count;
  };
  const auto bound = [](Unknowns& x) {
    x[4] = std::max(x[4], kSlowestRise_mm_s);
    const double speed = x.segment<3>(2).norm();
    if (speed > kFastestShot_mm_s) x.segment<3>(2) *= kFastestShot_mm_s / speed;
  };
  Unknowns steps;
  steps << 0.1, 0.1, 1, 1, 1, 1e-5;
  ShotFit out;
  out.chi2 = fit<6>(at, steps, iterations, residuals, bound);
  out.shot = shot_of(at);
  return out;
}

}  // namespace sslv
