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

/// Mean of frames of a fixed camera, in red, green and blue. Bayer images are interpolated.
class MeanPicture {
 public:
  /// Returns false, and has no effect, if the frame is empty or monochrome, or if its size differs from the
  /// first frame's.
  bool add(const ImageView& frame);
  int frames() const { return frames_; }
  /// The larger image that contains this image.
  WholePicture whole{};
  int width() const { return sums_[0].width; }
  int height() const { return sums_[0].height; }
  /// Mean of channel 0 (red), 1 (green) or 2 (blue).
  FloatPicture channel(std::size_t i) const;

 private:
  std::array<FloatPicture, 3> sums_;
  int frames_ = 0;
};

/// Candidates for painted lines: pixels that are white and brighter than both sides.
struct LinePicture {
  FloatPicture light;        // mean of red, green and blue
  FloatPicture line;         // contrast of a pixel to its sides; 0: none
  FloatPicture distance_px;  // distance to the nearest pixel whose contrast exceeds min_line
  float noise = 1;           // standard deviation of `light`
  float min_line = 0;        // threshold for `line`

  int width() const { return light.width; }
  int height() const { return light.height; }
};

/// `line_px`: approximate width of painted lines in the image.
LinePicture find_line_pixels(const MeanPicture& picture, double line_px);

/// Value between pixels by bilinear interpolation; -1 outside the image.
float value_at(const FloatPicture& picture, double x, double y);

}  // namespace sslv
