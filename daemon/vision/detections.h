// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geometry/scene.h"

#include <cstdint>
#include <vector>

namespace sslv {

/// A robot on the field. Position on the plane z = height, orientation counter-clockwise from +x in (-pi,
/// pi].
struct Robot {
  Team team;
  int id;
  double x_mm, y_mm, orientation_rad, height_mm;
  double pixel_x, pixel_y;  // centre of the pattern in the image
  double confidence;        // 0 .. 1
};

/// A ball on the field; its position is that of its centre, one radius above the floor.
struct Ball {
  double x_mm, y_mm;
  double pixel_x, pixel_y;
  std::uint32_t area_px;
  double confidence;  // 0 .. 1
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
