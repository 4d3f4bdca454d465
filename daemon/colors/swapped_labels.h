// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/lut.h"

#include <vector>

namespace sslv {

/// A label whose cells have the hue of another.
struct SwappedLabel {
  Label label, looks_like;
};

/// Labels of the ball and of the league's patterns that a table gives to colours of another of them: pink to
/// green, for instance, which makes every robot one with another id. Orange, yellow and green lie too near
/// each other for that; such a mistake loses robots.
std::vector<SwappedLabel> swapped_labels(const ColorTable& table);

}  // namespace sslv
