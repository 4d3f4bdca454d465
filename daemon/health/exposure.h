// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"
#include "vision/mask.h"

#include <optional>

namespace sslv {

/// Brightness of the part of an image that the mask does not hide.
struct Exposure {
  double clipped_share = 0;  // share of pixels with a channel (YUV: luma) of 250 or more
  double dark_share = 0;     // share of pixels with a luma of 5 or less
  double mean_luma = 0;      // 0 .. 255
};

/// Measures some 20000 evenly spread pixels; in Bayer images, quads count as pixels. Nothing if the mask
/// hides all pixels.
std::optional<Exposure> measure_exposure(const ImageView& image, const Mask& mask);

}  // namespace sslv
