// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "clips/clip.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace sslv {

/// An image with its memory, whose address does not change when moved.
struct OwnedImage {
  std::vector<std::uint8_t> bytes;
  ImageView view;
};

/// Noise that depends on `seed`, also in the `padding` bytes of each row. `is_deep`: with low bits.
inline OwnedImage noise_image(PixelFormat format, int width, int height, unsigned seed, int padding = 0,
                              bool is_deep = false) {
  OwnedImage out;
  const int stride = width * bytes_per_pixel(format) + padding;
  const auto plane = static_cast<std::size_t>(stride * height);
  out.bytes.resize(plane * (is_deep ? 2 : 1));
  std::uint32_t state = seed * 2654435761U + 1;
  for (std::uint8_t& byte : out.bytes) {
    state = state * 1664525U + 1013904223U;
    byte = static_cast<std::uint8_t>(state >> 24U);
  }
  out.view = {out.bytes.data(), width, height, stride, format};
  if (is_deep) out.view.to_low_bits = static_cast<std::ptrdiff_t>(plane);
  return out;
}

/// All pixels row by row, then all low bits.
inline std::vector<std::uint8_t> pixels_of(const ImageView& view) {
  std::vector<std::uint8_t> out;
  for (const std::ptrdiff_t plane : {std::ptrdiff_t{0}, view.to_low_bits}) {
    if (plane == 0 && !out.empty()) break;
    for (int y = 0; y < view.height && !view.empty(); ++y) {
      const std::uint8_t* row = view.row(y) + plane;
      out.insert(out.end(), row, row + view.width * bytes_per_pixel(view.format));
    }
  }
  return out;
}

}  // namespace sslv
