// SPDX-License-Identifier: Apache-2.0
#pragma once

// Colour of single pixels in any format, for code that reads only a few, such as stage libraries. Slower than
// code for one format: vision/segment.h, vision/sample_planes.h.

#include "image/color.h"
#include "image/image.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

namespace sslv {

/// Colour that a Bayer image measures at a pixel: 0 red, 1 green, 2 blue.
constexpr std::size_t bayer_color(PixelFormat format, int x, int y) {
  // Position of red in the quad 0 1 / 2 3.
  const int red = static_cast<int>(format) - static_cast<int>(PixelFormat::kBayerRg8);
  return static_cast<std::size_t>(((x ^ red) & 1) + ((y ^ red >> 1) & 1));
}

/// Red, green and blue at pixel (x, y), which must lie in the image. Bayer: interpolated linearly between the
/// nearest samples of each colour, so that the colours are not shifted; mono: grey.
inline Rgb rgb_at(const ImageView& image, int x, int y) {
  const std::uint8_t* row = image.row(y);
  const auto yuv422 = [&](int luma, int u) {
    const std::uint8_t* pair = row + static_cast<std::ptrdiff_t>(x / 2) * 4;
    return to_rgb({pair[luma + x % 2 * 2], pair[u], pair[u + 2]});
  };
  const std::uint8_t* three = row + static_cast<std::ptrdiff_t>(x) * 3;
  switch (image.format) {
    case PixelFormat::kUyvy: return yuv422(1, 0);
    case PixelFormat::kYuyv: return yuv422(0, 1);
    case PixelFormat::kRgb24: return {three[0], three[1], three[2]};
    case PixelFormat::kBgr24: return {three[2], three[1], three[0]};
    case PixelFormat::kMono8: return {row[x], row[x], row[x]};
    default: break;
  }
  // Mirrored at the edge: the neighbour on the other side measures the same colour.
  const auto inside = [](int at, int size) {
    return std::clamp(at < 0 ? -at : at >= size ? 2 * size - 2 - at : at, 0, size - 1);
  };
  std::array<int, 3> sum{}, weights{};
  for (int dy = -1; dy <= 1; ++dy) {
    const int at_y = inside(y + dy, image.height);
    for (int dx = -1; dx <= 1; ++dx) {
      const int at_x = inside(x + dx, image.width);
      const int weight = (2 - std::abs(dx)) * (2 - std::abs(dy));
      const std::size_t color = bayer_color(image.format, at_x, at_y);
      sum[color] += weight * image.row(at_y)[at_x];
      weights[color] += weight;
    }
  }
  const auto mean = [&](std::size_t color) {
    const int weight = std::max(weights[color], 1);
    return static_cast<std::uint8_t>((sum[color] + weight / 2) / weight);
  };
  return {mean(0), mean(1), mean(2)};
}

/// Brightness (Y) at pixel (x, y), which must lie in the image.
inline std::uint8_t grey_at(const ImageView& image, int x, int y) {
  switch (image.format) {
    case PixelFormat::kUyvy: return image.row(y)[2 * x + 1];
    case PixelFormat::kYuyv: return image.row(y)[2 * x];
    case PixelFormat::kMono8: return image.row(y)[x];
    default: return to_yuv(rgb_at(image, x, y)).y;
  }
}

/// Copies the brightness of all pixels, row by row.
inline void copy_grey(const ImageView& image, std::vector<std::uint8_t>& out) {
  out.resize(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  std::uint8_t* to = out.data();
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) *to++ = grey_at(image, x, y);
}

}  // namespace sslv
