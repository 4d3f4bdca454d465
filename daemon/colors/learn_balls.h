// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "colors/learn_robots.h"

#include <optional>
#include <span>
#include <vector>

namespace sslv {

/// A ball that the image shows.
struct SeenBall {
  std::size_t frame;
  double pixel_x, pixel_y, radius_px;
  Color3 body;                 // its colour beside its shine
  std::vector<Color3> shades;  // its colours from there to its shine
  double r2;
};

/// What balls are looked for by.
struct BallSearch {
  const RobotSearch& search;
  const CameraModel& camera;
  const FieldSize& field;
  bool on_field_only;                       // the camera tells what lies on the field
  std::span<const SeenRobot> robots;        // that may hide one; nothing on them is a ball
  Color3 white_chromaticity;                // what is white has these
  Color3 carpet_chromaticity;               // what a ball lies on
  std::optional<Color3> yellow;             // a ball is redder
  std::optional<Color3> ball_chromaticity;  // as people pointed at it
};

/// Balls: round, of the ball's size, on carpet, on the field, and of one warm colour, redder than yellow. Of
/// several colours the likeliest counts.
std::vector<SeenBall> find_balls(const BallSearch& search);

}  // namespace sslv
