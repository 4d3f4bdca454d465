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

/// Chromaticity of the surface that robots stand on. Returns nothing if the robots stand on different
/// surfaces, or if too little of the surface is visible.
std::optional<Color3> carpet_chromaticity(const RobotSearch& search, std::span<const SeenRobot> robots);

/// Samples of the carpet over its whole range of brightness, and of the lines on it.
struct CarpetAndLines {
  std::vector<ColorSample> samples;
  Color3 white_chromaticity;  // chromaticity of the lines; without lines, derived from the gains
};
CarpetAndLines carpet_and_lines(const RobotSearch& search, std::span<const SeenRobot> robots,
                                const Color3& carpet_chromaticity, const Color3& gains);

}  // namespace sslv
