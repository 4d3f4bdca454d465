// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "chance.h"
#include "image/image.h"
#include "light_color.h"

#include <cstdint>
#include <span>
#include <vector>

namespace sslv::halls {

/// An image in linear light; `pixels` row by row.
struct Picture {
  int width = 0, height = 0;
  std::vector<Color> pixels;

  Picture() = default;
  Picture(int w, int h)
      : width(w),
        height(h),
        pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), Color::Zero()) {}
  std::span<Color> row(int y) {
    return {pixels.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width),
            static_cast<std::size_t>(width)};
  }
};

struct HotPixel {
  int x, y, channel;
  float light;
};

struct Sensor {
  // The time of a frame is the middle of the middle row's exposure.
  double exposure_s = 0;
  double readout_s = 0;  // from the first row's exposure to the last row's
  Transfer transfer = Transfer::kLinear;
  double blur_px = 0.55;    // the lens: standard deviation
  double noise_grey = 4;    // standard deviation at grey 90 of 255, of each colour
  double shot_share = 0.3;  // fraction of that variance which grows with the light
  bool is_mosaic = false;   // the camera makes uyvy and rgb24 from a Bayer sensor
  int jpeg_quality = 0;     // 0: not compressed
  std::vector<HotPixel> hot_pixels;
};

/// Gaussian blur, in place.
void blur(Picture& picture, double sigma_px);

/// The camera's output: kUyvy, kRgb24 or kBayerRg8. Bayer images are never compressed.
std::vector<std::uint8_t> camera_bytes(const Picture& light, const Sensor& sensor, PixelFormat format,
                                       Chance chance);

}  // namespace sslv::halls
