// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/lut.h"

#include <array>
#include <span>

namespace sslv {

/// The likeliest of several colours.
struct ColorName {
  Label color = label::kClear;
  double margin = 0;  // 0: might as well be the second likeliest; 1: just as the table's colour; less than 0:
                      // the colour table contradicts
  double off = 0;  // distance of its shares of red, green and blue from those of the table's colour, over the
                   // spread of these; for a colour that is only purer, its distance in hue
};

/// From here on a channel counts as clipped: averages over a dot end a little below 255, for noise is clipped
/// too.
inline constexpr double kClippedGrey = 250;

/// A contrast as it was before clipping: channels of `color` at their upper end may have been any brighter,
/// up to twice as much, and count as what makes the contrast's shares most like these. In grey levels, red,
/// green, blue.
std::array<double, 3> unclipped(const std::array<double, 3>& contrast, const std::array<double, 3>& color,
                                const std::array<double, 3>& chromaticity) noexcept;

/// Names the colour of an evenly coloured thing. The shares of red, green and blue in its contrast to the
/// black (or dark) ground, which stay when the light changes, are compared with those of the table's labels;
/// the table itself is asked about its colour, which is freer of noise than any pixel's. What is clipped
/// counts as whatever brings it nearest to each label. Both in grey levels, red, green, blue. `allowed` has
/// at least one label.
ColorName name_color(const std::array<double, 3>& contrast, const std::array<double, 3>& color,
                     const Lut& lut, std::span<const Label> allowed) noexcept;

}  // namespace sslv
