// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/label.h"
#include "vision/lut.h"

#include <array>
#include <vector>

namespace sslv {

/// Change of the light since a table was accepted.
struct LightChange {
  std::array<double, 3> gain{1, 1, 1};  // factors on red, green and blue, in the whole image
  /// Smallest and largest factor on `gain` of any area, if the distribution of the light has changed.
  double darkest_area = 1, brightest_area = 1;

  bool operator==(const LightChange&) const = default;
};

/// The table as it would be if it had been made in the current light: a colour gets the label that the same
/// object had when the table was accepted. Works with every table, because only the table's cells are used.
///
/// Three effects go beyond a change of scale. A clipped channel may have been brighter by any amount, so the
/// labels of all possible colours vote. If areas differ in light, a label found in the light of any area
/// counts, average light first, but cells labelled field, white or black keep their label. In weak light
/// noise stays as strong while colours move closer together, so the labels of prints grow into clear cells by
/// the amount that the scaling removed, up to two cells. Prints change with the light's colour.
ColorTable table_in_light(const Lut& accepted, const LightChange& change);

}  // namespace sslv
