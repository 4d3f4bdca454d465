// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "colors/learn_balls.h"
#include "colors/learn_robots.h"
#include "vision/lut.h"
#include "vision/lut_from_samples.h"

#include <optional>
#include <span>
#include <vector>

namespace sslv {

/// What robots stand on: shares of red, green and blue. Nothing when they do not stand on one thing.
std::optional<Color3> carpet_chromaticity(const RobotSearch& search, std::span<const SeenRobot> robots);

/// Samples of the carpet in all its lights, and of the lines on it.
struct CarpetAndLines {
  std::vector<ColorSample> samples;
  Color3
      white_chromaticity;  // what is white has these shares: of the lines or, without any, as the gains say
};
CarpetAndLines carpet_and_lines(const RobotSearch& search, std::span<const SeenRobot> robots,
                                const Color3& carpet_chromaticity, const Color3& gains);

}  // namespace sslv
