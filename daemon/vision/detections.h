// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geometry/scene.h"

#include <cstdint>
#include <vector>

namespace sslv {

/// How sure a place is, as the fit to the image says: without what the calibration is off. Zeros: not known.
/// It stays inside the process; the league's packet has no room for it.
struct PlaceCov {
  double xx_mm2 = 0, xy_mm2 = 0, yy_mm2 = 0;
};

/// A robot on the field. Position on the plane z = height, orientation counter-clockwise from +x in (-pi,
/// pi].
struct Robot {
  Team team;
  int id;
  double x_mm, y_mm, orientation_rad, height_mm;
  double pixel_x, pixel_y;  // centre of the pattern in the image
  double confidence;        // 0 .. 1
  PlaceCov place_cov{};
  double orientation_sigma_rad = 0;  // 0: not known
};

/// A ball on the field; its position is that of its centre, one radius above the floor.
struct Ball {
  double x_mm, y_mm;
  double pixel_x, pixel_y;
  std::uint32_t area_px;
  double confidence;  // 0 .. 1
  PlaceCov place_cov{};
  /// The radius that fits best, on the plane of its centre: a ball in the air looks larger. Sigma 0: not
  /// known.
  double radius_mm = 0, radius_sigma_mm = 0;
};

/// Both sorted by falling confidence. Distinct types, so that each is a part of a frame by itself.
struct RobotList {
  std::vector<Robot> robots;
  bool capped = false;                 // there was more to look at than the time allows: the frame is flagged
  std::vector<Robot> second_robots{};  // left out, because each has the id of one of `robots`
};
struct BallList {
  std::vector<Ball> balls;
  bool capped = false;
};

}  // namespace sslv
