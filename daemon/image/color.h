// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

namespace sslv {

/// BT.601 full range, 8 bits per channel; U and V are 128 for grey.
struct Yuv {
  std::uint8_t y, u, v;
  bool operator==(const Yuv&) const = default;
};
/// 8 bits per channel.
struct Rgb {
  std::uint8_t r, g, b;
  bool operator==(const Rgb&) const = default;
};

/// BT.601 full range (JFIF 1.02), in 16-bit fixed point, rounded.
constexpr Yuv to_yuv(Rgb c) {
  const int y = 19595 * c.r + 38470 * c.g + 7471 * c.b;
  const int u = -11059 * c.r - 21709 * c.g + 32768 * c.b;
  const int v = 32768 * c.r - 27439 * c.g - 5329 * c.b;
  const auto byte = [](int fixed, int offset) {
    return static_cast<std::uint8_t>(std::clamp(((fixed + 32768) >> 16) + offset, 0, 255));
  };
  return {byte(y, 0), byte(u, 128), byte(v, 128)};
}

/// Inverse of to_yuv up to rounding; colours outside the RGB cube are clamped to it.
constexpr Rgb to_rgb(Yuv c) {
  const int u = c.u - 128, v = c.v - 128, y = c.y << 16;
  const auto byte = [](int fixed) {
    return static_cast<std::uint8_t>(std::clamp((fixed + 32768) >> 16, 0, 255));
  };
  return {byte(y + 91881 * v), byte(y - 22554 * u - 46802 * v), byte(y + 116130 * u)};
}

}  // namespace sslv
