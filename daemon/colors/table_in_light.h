// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/label.h"
#include "vision/lut.h"

#include <array>
#include <vector>

namespace sslv {

/// How light differs from that in which a table was accepted.
struct LightChange {
  std::array<double, 3> gain{1, 1, 1};  // of red, green and blue, in the whole image
  /// Where light is uneven in another way than it was: the least and the greatest factor on `gain` that parts
  /// of the image have.
  double darkest_area = 1, brightest_area = 1;

  bool operator==(const LightChange&) const = default;
};

/// The table as it would be if it had been made in the current light: a colour gets the label that the same
/// thing had then. Works with every table, since only its cells count.
///
/// Three things are more than a change of scale. A channel at its upper end may have been anything beyond, so
/// what most of that were counts. Where areas differ, a colour of any of them counts, the middle light first,
/// and what is named as field, white or black stays that. In weak light noise stays as strong while colours
/// move together, so labels of colours grow into clear cells by what the scale took from them, up to two
/// cells. Prints change with the light's colour.
ColorTable table_in_light(const Lut& accepted, const LightChange& change);

}  // namespace sslv
