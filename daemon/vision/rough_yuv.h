// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/color.h"

#include <array>
#include <cstdint>

namespace sslv {

/// Approximates the YUV of an RGB colour using only averages of bytes, (a + b + 1) / 2, because CPUs compute
/// 16 to 64 of them in one step. The true YUV, and also the YUV of the 7-bit table cell that contains the
/// colour, is the result plus an error within kRoughYuvError.
constexpr Yuv rough_yuv(Rgb c) {
  const auto average = [](int a, int b) { return (a + b + 1) / 2; };
  // 0.34 R + 0.66 G, and 0.84 G + 0.16 B
  const int red_green = average(c.g, average(c.r, average(c.g, average(c.r, average(c.g, c.r)))));
  const int green_blue = average(c.g, average(c.g, average(c.b, average(c.g, average(c.b, c.g)))));
  const int y = average(red_green, average(red_green, average(red_green, c.b)));
  return {static_cast<std::uint8_t>(y), static_cast<std::uint8_t>(average(c.b, 255 - red_green)),
          static_cast<std::uint8_t>(average(c.r, 255 - green_blue))};
}

/// Smallest and largest error of U, V and Y.
inline constexpr std::array<std::array<int, 2>, 3> kRoughYuvError{{{-1, 2}, {-1, 2}, {-5, 4}}};

}  // namespace sslv
