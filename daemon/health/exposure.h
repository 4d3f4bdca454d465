// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"
#include "vision/mask.h"

#include <optional>

namespace sslv {

/// How bright an image is, where it is looked at.
struct Exposure {
  double clipped_share = 0;  // of its pixels: a channel (YUV: luma) is 250 or more
  double dark_share = 0;     // luma is 5 or less
  double mean_luma = 0;      // 0 .. 255
};

/// Of some 20000 pixels, evenly spread; a Bayer image's quads count as pixels. Nothing when the mask hides
/// all of them.
std::optional<Exposure> measure_exposure(const ImageView& image, const Mask& mask);

}  // namespace sslv
