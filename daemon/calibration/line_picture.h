// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/frame_info.h"
#include "image/image.h"

#include <array>
#include <cstddef>
#include <vector>

namespace sslv {

/// One float for each pixel.
struct FloatPicture {
  int width = 0, height = 0;
  std::vector<float> values;

  FloatPicture() = default;
  FloatPicture(int w, int h, float value = 0)
      : width(w), height(h), values(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), value) {}
  float* row(int y) { return values.data() + std::ptrdiff_t{y} * width; }
  const float* row(int y) const { return values.data() + std::ptrdiff_t{y} * width; }
};

/// The mean of frames of a standing camera, red, green and blue; Bayer images are interpolated.
class MeanPicture {
 public:
  /// False for a frame of another size than the first, or without colours; it is left out.
  bool add(const ImageView& frame);
  int frames() const { return frames_; }
  /// What the image is a part of.
  WholePicture whole{};
  int width() const { return sums_[0].width; }
  int height() const { return sums_[0].height; }
  /// A channel's mean.
  FloatPicture channel(std::size_t i) const;

 private:
  std::array<FloatPicture, 3> sums_;
  int frames_ = 0;
};

/// What in an image might be painted lines: white, and brighter than both sides.
struct LinePicture {
  FloatPicture light;        // mean of red, green and blue
  FloatPicture line;         // by how much a pixel stands out against its sides; 0: it does not
  FloatPicture distance_px;  // to the nearest pixel that stands out enough
  float noise = 1;           // standard deviation of `light`
  float min_line = 0;        // what is enough

  int width() const { return light.width; }
  int height() const { return light.height; }
};

/// `line_px` is about how wide painted lines are in the image.
LinePicture find_line_pixels(const MeanPicture& picture, double line_px);

/// Between pixels, by linear interpolation; -1 outside the image.
float value_at(const FloatPicture& picture, double x, double y);

}  // namespace sslv
