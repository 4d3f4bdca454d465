// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/lut.h"

#include <array>
#include <span>

namespace sslv {

/// The likeliest of several colours.
struct ColorName {
  Label color = label::kClear;
  double margin = 0;  // 0: the second likeliest colour is equally likely; 1: exactly the table's colour;
                      // below 0: the table gives this colour another label
  double off = 0;  // distance of its chromaticity (shares of red, green and blue) from the label's, divided
                   // by the label's spread; higher purity does not count
};

/// Channels from this level on count as clipped. Averages over a clipped dot are a little below 255, because
/// noise is clipped too.
inline constexpr double kClippedGrey = 250;

/// Estimates a contrast before clipping. Clipped channels of `color` may have been up to twice as bright;
/// they are set to the values for which the contrast's chromaticity is nearest to `chromaticity`. All values
/// are in grey levels: red, green, blue.
std::array<double, 3> unclipped(const std::array<double, 3>& contrast, const std::array<double, 3>& color,
                                const std::array<double, 3>& chromaticity) noexcept;

/// Names the colour of an evenly coloured object. Compares the chromaticity of each label in the table with
/// the chromaticity of the object's contrast to the black or dark ground: neither changes with the light.
/// Also looks up the object's colour in the table, because this colour has less noise than a single pixel.
/// For each label, clipped channels count with the values that are nearest to the label. `contrast` and
/// `color` are in grey levels: red, green, blue. `allowed` has at least one label.
ColorName name_color(const std::array<double, 3>& contrast, const std::array<double, 3>& color,
                     const Lut& lut, std::span<const Label> allowed) noexcept;

}  // namespace sslv
