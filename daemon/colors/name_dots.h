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

/// About what a print of this label looks like in white light. Only differences between prints are relied on:
/// they say which group of colours is which, and what a colour looks like that was not seen.
Color3 print_color(Label label);

/// Shares of red, green and blue, with sum 1: what stays of a colour's contrast to black when the light
/// changes.
Color3 chromaticity_of(const Color3& contrast);

/// A dot's contrast to black. Clipped channels may have been brighter: they are as near to these shares as
/// they may have been.
Color3 unclipped_contrast(const SeenDot& dot, const Color3& chromaticity);

/// The labels of robots' dots.
struct NamedDots {
  std::string problem;  // as LearntColors
  std::vector<std::string> notes;
  std::vector<std::vector<Label>> labels;  // of each robot: the centre's, then those of the side dots
  std::map<Label, Color3> chromaticities;  // of those that were seen: of the dots' contrast to black
  std::vector<Label> unseen;               // of the table's colours
  Color3 gains = Color3::Ones();           // of red, green and blue: the light's and the camera's cast
};

/// Groups the dots' colours, centres and side dots apart, and names the groups. `guide` holds what people
/// pointed at.
NamedDots name_dots(std::span<const SeenRobot> robots, const PatternTable& patterns,
                    std::span<const ColorSample> guide);

}  // namespace sslv
