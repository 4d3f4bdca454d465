// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace sslv {

/// A rectangle of pixels; right and bottom are one past the last pixel.
struct DrawnBox {
  int left, top, right, bottom;
  bool empty() const { return left >= right || top >= bottom; }
};

/// The light that falls on each pixel, before lens blur, saturation and colour filter: red, green, blue in
/// steps of 1/kPerGrey of an 8-bit grey level.
struct LightPicture {
  static constexpr int kPerGrey = 64;

  LightPicture(int width_px, int height_px)
      : width(width_px),
        height(height_px),
        rgb(3 * static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px)) {}

  const std::uint16_t* at(int x, int y) const { return rgb.data() + offset(x, y); }
  std::uint16_t* at(int x, int y) { return rgb.data() + offset(x, y); }

  int width, height;
  std::vector<std::uint16_t> rgb;

 private:
  std::size_t offset(int x, int y) const {
    return 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
  }
};

}  // namespace sslv
