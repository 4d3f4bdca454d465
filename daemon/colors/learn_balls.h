// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "colors/learn_robots.h"

#include <optional>
#include <span>
#include <vector>

namespace sslv {

/// A ball found in an image.
struct SeenBall {
  std::size_t frame;
  double pixel_x, pixel_y, radius_px;
  Color3 body;                 // the ball's colour outside the highlight
  std::vector<Color3> shades;  // the ball's colours from `body` to the highlight
  double r2;
};

/// Input of find_balls().
struct BallSearch {
  const RobotSearch& search;
  const CameraModel& camera;
  const FieldSize& field;
  bool on_field_only;                       // needs a real calibration
  std::span<const SeenRobot> robots;        // robots may hide a ball; objects on robots are not balls
  Color3 white_chromaticity;                // chromaticity of white surfaces
  Color3 carpet_chromaticity;               // chromaticity of the surface under a ball
  std::optional<Color3> yellow;             // contrast of yellow dots; a ball is redder
  std::optional<Color3> ball_chromaticity;  // from samples that the user pointed at
};

/// Finds round objects of the ball's size that lie on the field's carpet and have one warm colour, redder
/// than yellow. If the balls found have several colours, only balls of the likeliest colour are returned.
std::vector<SeenBall> find_balls(const BallSearch& search);

}  // namespace sslv
