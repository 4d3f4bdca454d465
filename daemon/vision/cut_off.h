// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"
#include "vision/mask.h"
#include "vision/regions.h"

namespace sslv {

/// Whether `mask` cuts the region: then it is a piece of something larger, such as a board, and its area and
/// centroid say nothing. What the image's own edge cuts does not count. `region` is of an image of this
/// size and format, segmented with this mask.
bool is_cut_off(const Region& region, const ImageView& image, const Mask& mask);

}  // namespace sslv
