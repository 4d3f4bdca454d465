// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geometry/scene.h"

#include <cstdint>
#include <vector>

namespace sslv {

/// Covariance of a position, from the fit to the image, without calibration errors. Zeros: unknown. Not
/// published, because the league's packet has no field for it.
struct PlaceCov {
  double xx_mm2 = 0, xy_mm2 = 0, yy_mm2 = 0;
};

/// A robot on the field. Position on the plane z = height, orientation counter-clockwise from +x in (-pi,
/// pi].
struct Robot {
  Team team;
  int id;
  double x_mm, y_mm, orientation_rad, height_mm;
  double pixel_x, pixel_y;  // the robot's centre in the image
  double confidence;        // 0 .. 1
  PlaceCov place_cov{};
  double orientation_sigma_rad = 0;  // 0: not known
};

/// A ball on the field; the position is the ball's centre, one radius above the floor.
struct Ball {
  double x_mm, y_mm;
  double pixel_x, pixel_y;
  std::uint32_t area_px;
  double confidence;  // 0 .. 1
  PlaceCov place_cov{};
  /// The radius that fits best if the ball lies on the floor: a ball in the air looks larger. Sigma 0: not
  /// known.
  double radius_mm = 0, radius_sigma_mm = 0;
};

/// Something that resembles a robot, and why it is none.
struct RobotMiss {
  /// What is wrong; later values are nearer to a robot.
  enum class Why : std::uint8_t {
    kDots,        // `dots` of `of` dots are at their places, the centre dot included
    kFit,         // the dots' rms distance from their places, `value` in mm, is above `limit`
    kColors,      // the colour of `dots` of `of` dots is certain
    kTeam,        // the centre dot has neither team's colour
    kId,          // `value` ids have these colours; must be 1
    kConfidence,  // `value` is below `limit`
  };
  Why why;
  double pixel_x, pixel_y, radius_px;
  int dots, of;
  double value, limit;
};

/// Both lists are sorted by falling confidence. They are distinct types, so that each is a separate part of a
/// frame.
struct RobotList {
  std::vector<Robot> robots;
  bool capped = false;                 // the search reached its limit of work: the frame is flagged
  std::vector<Robot> second_robots{};  // left out of `robots`, which already has their ids
  std::vector<RobotMiss> misses{};     // nearest first
};
/// See RobotList.
struct BallList {
  std::vector<Ball> balls;
  bool capped = false;
};

}  // namespace sslv
