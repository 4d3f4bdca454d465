// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tracking/ball_motion.h"

#include <optional>
#include <span>

#include <Eigen/Core>

namespace sslv {

/// A ball measurement, as used by the fits.
struct ShotPoint {
  double t_s;
  Eigen::Vector3d camera_mm;  // the camera's position
  Eigen::Vector2d place_mm;   // projected onto the floor (z = ball radius)
  double sigma_mm;
  double height_mm, height_sigma_mm;  // the ball's centre, from its apparent size
};

/// Priors of a fit.
struct ShotPrior {
  double place_sigma_mm = 3, t_sigma_s = 2e-3;
  double slides_sigma_mm_s2 = 300;
  double rises_deg = 45, rises_sigma_deg = 6;  // elevation angle of a chip
  /// The kicking robot's heading (unit vector) and velocity. The ball keeps part of this velocity.
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

/// Maximum number of points that a fit uses; it ignores further points.
inline constexpr std::size_t kMaxShotPoints = 50;

/// Fits a shot along the floor, starting from `guess`: position, velocity and deceleration. The kick's time
/// is fixed. chi2 includes the priors.
ShotFit fit_flat(const ShotFit& guess, std::span<const ShotPoint> points, const BallModel& model,
                 const ShotPrior& prior);

/// Fits a chip: position, velocity and the kick's time. A ball in the air is projected to a floor position
/// farther from the camera. chi2 includes the priors.
ShotFit fit_chip(const ShotFit& guess, std::span<const ShotPoint> points, const BallModel& model,
                 const ShotPrior& prior, int iterations);

}  // namespace sslv
