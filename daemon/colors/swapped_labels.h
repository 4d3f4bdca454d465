// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/lut.h"

#include <vector>

namespace sslv {

/// A label whose cells have the hue of another label.
struct SwappedLabel {
  Label label, looks_like;
};

/// Labels of the ball and of the league's patterns whose cells have the colour of another of these labels: a
/// table that labels green as pink, for instance, gives every robot another id. Swaps among orange, yellow
/// and green are not found, because their hues are too close to each other; a table with one of these swaps
/// detects no robots.
std::vector<SwappedLabel> swapped_labels(const ColorTable& table);

}  // namespace sslv
