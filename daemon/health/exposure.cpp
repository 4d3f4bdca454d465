// SPDX-License-Identifier: Apache-2.0
#include "health/exposure.h"

#include "image/color.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace sslv {
namespace {

struct Brightness {
  int luma, brightest;  // brightest channel
};

/// Brightness of a pixel or, in a Bayer image, of a quad.
Brightness brightness(const ImageView& image, int x, int y) {
  const auto of_rgb = [](Rgb c) { return Brightness{to_yuv(c).y, std::max({c.r, c.g, c.b})}; };
  switch (image.format) {
    case PixelFormat::kUyvy: {
      const int luma = image.row(y)[2 * x + 1];
      return {luma, luma};
    }
    case PixelFormat::kYuyv: {
      const int luma = image.row(y)[2 * x];
      return {luma, luma};
    }
    case PixelFormat::kRgb24: {
      const std::uint8_t* at = image.row(y) + 3 * x;
      return of_rgb({at[0], at[1], at[2]});
    }
    case PixelFormat::kBgr24: {
      const std::uint8_t* at = image.row(y) + 3 * x;
      return of_rgb({at[2], at[1], at[0]});
    }
    case PixelFormat::kMono8: {
      const int luma = image.row(y)[x];
      return {luma, luma};
    }
    case PixelFormat::kBayerRg8:
    case PixelFormat::kBayerGr8:
    case PixelFormat::kBayerGb8:
    case PixelFormat::kBayerBg8: break;
  }
  const std::uint8_t* above = image.row(2 * y) + 2 * x;
  const std::uint8_t* below = image.row(2 * y + 1) + 2 * x;
  // Two of the four pixels are green, so the mean of the four is near enough to luma.
  return {(above[0] + above[1] + below[0] + below[1] + 2) / 4,
          std::max({above[0], above[1], below[0], below[1]})};
}

}  // namespace

std::optional<Exposure> measure_exposure(const ImageView& image, const Mask& mask) {
  constexpr double kSamples = 20'000;
  constexpr int kClipped = 250, kDark = 5;
  const int cell_px = is_bayer(image.format) ? 2 : 1;
  const int width = image.width / cell_px, height = image.height / cell_px;
  const int step =
      std::max(1, static_cast<int>(std::lround(std::sqrt(static_cast<double>(width) * height / kSamples))));
  std::int64_t samples = 0, clipped = 0, dark = 0, luma_sum = 0;
  for (int y = step / 2; y < height; y += step) {
    for (const Mask::Interval& interval : mask.row(y, cell_px)) {
      const int begin = interval.begin, end = std::min<int>(interval.end, width);
      for (int x = step / 2 + (std::max(0, begin - step / 2) + step - 1) / step * step; x < end; x += step) {
        const Brightness here = brightness(image, x, y);
        ++samples;
        clipped += here.brightest >= kClipped ? 1 : 0;
        dark += here.luma <= kDark ? 1 : 0;
        luma_sum += here.luma;
      }
    }
  }
  if (samples == 0) return std::nullopt;
  const auto n = static_cast<double>(samples);
  return Exposure{static_cast<double>(clipped) / n, static_cast<double>(dark) / n,
                  static_cast<double>(luma_sum) / n};
}

}  // namespace sslv
