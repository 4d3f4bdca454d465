// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tracking/ball_motion.h"

#include <optional>
#include <span>

#include <Eigen/Core>

namespace sslv {

/// A sighting of a ball after a kick.
struct ShotPoint {
  double t_s;
  Eigen::Vector3d camera_mm;  // where the camera hangs that saw it
  Eigen::Vector2d place_mm;   // as if on the floor
  double sigma_mm;
  double height_mm, height_sigma_mm;  // of its centre, as its size tells
};

/// What is known before a fit.
struct ShotPrior {
  double place_sigma_mm = 3, t_sigma_s = 2e-3;
  double slides_sigma_mm_s2 = 300;
  double rises_deg = 45, rises_sigma_deg = 6;  // of a chip
  /// Where the robot that kicked looked, and its velocity, of which the ball keeps a part.
  struct Robot {
    Eigen::Vector2d ahead{1, 0}, velocity_mm_s{0, 0};
  };
  std::optional<Robot> robot;
};

struct ShotFit {
  BallShot shot;
  double slides_mm_s2 = 0;
  double chi2 = 0;
};

/// The most points that are looked at.
inline constexpr std::size_t kMaxShotPoints = 50;

/// A shot along the floor, from a first guess; its moment stays. Gauss-Newton over place, velocity and
/// deceleration.
ShotFit fit_flat(const ShotFit& guess, std::span<const ShotPoint> points, const BallModel& model,
                 const ShotPrior& prior);

/// A chip; its moment is fitted, too. What a camera sees of a ball in the air lies farther out.
ShotFit fit_chip(const ShotFit& guess, std::span<const ShotPoint> points, const BallModel& model,
                 const ShotPrior& prior, int iterations);

}  // namespace sslv
