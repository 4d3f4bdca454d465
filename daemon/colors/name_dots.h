// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "colors/learn_robots.h"
#include "vision/label.h"
#include "vision/lut_from_samples.h"
#include "vision/patterns.h"

#include <map>
#include <span>
#include <string>
#include <vector>

namespace sslv {

/// Approximate colour of a print of this label in white light. Only differences between prints are used: to
/// identify groups of colours, and to predict colours that were not seen.
Color3 print_color(Label label);

/// Shares of red, green and blue, with sum 1: the part of a colour's contrast to black that does not change
/// with the brightness of the light.
Color3 chromaticity_of(const Color3& contrast);

/// Distance of chromaticities within which a colour counts as the carpet's.
inline constexpr double kCarpetAlike = 0.07;

/// A dot's contrast to black. Clipped channels, which may have been brighter, are raised so that the contrast
/// best matches this chromaticity.
Color3 unclipped_contrast(const SeenDot& dot, const Color3& chromaticity);

/// The labels of robots' dots.
struct NamedDots {
  std::string problem;  // as in LearntColors
  std::vector<std::string> notes;
  std::vector<std::vector<Label>> labels;  // for each robot: the centre, then the side dots
  std::map<Label, Color3> chromaticities;  // from the dots' contrast to black, for seen labels
  std::vector<Label> unseen;               // colours of the pattern table that were not seen
  Color3 gains = Color3::Ones();           // gains of red, green, blue: colour cast of light and camera
};

/// Groups the dots' colours, separately for centres and side dots, and names the groups. `guide`: samples
/// that the user pointed at.
NamedDots name_dots(std::span<const SeenRobot> robots, const PatternTable& patterns,
                    std::span<const ColorSample> guide);

}  // namespace sslv
