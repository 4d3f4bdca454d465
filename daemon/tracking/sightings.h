// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geometry/scene.h"

#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>

namespace sslv {

/// A robot as one camera saw it.
struct RobotSighting {
  Team team;
  int id;
  Eigen::Vector2d place_mm;  // on the plane z = height_mm
  double orientation_rad;
  double height_mm;
  Eigen::Matrix2d place_cov_mm2;  // of the fit alone, without what the calibration adds
  double orientation_sigma_rad;
};

/// A ball as one camera saw it, as if it lay on the floor.
struct BallSighting {
  Eigen::Vector2d place_mm;  // on the plane z = the ball's radius
  Eigen::Matrix2d place_cov_mm2;
  double confidence;  // 0 .. 1
  /// Of its centre, as its size in the image tells; far less sure than its place.
  double height_mm = 0, height_sigma_mm = std::numeric_limits<double>::infinity();
};

/// What one camera saw in one image.
struct CameraSightings {
  int camera = 0;
  std::uint32_t frame_number = 0;
  double t_capture_s = 0;  // as the camera's computer says
  std::vector<RobotSighting> robots;
  std::vector<BallSighting> balls;
};

}  // namespace sslv
