// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"
#include "vision/mask.h"
#include "vision/regions.h"

namespace sslv {

/// Whether `mask` cuts the region. Then the region is a part of a larger object, such as a board, and its
/// area and centroid are meaningless. Cuts by the image's own edge do not count. `region` must be of an image
/// of this size and format, segmented with this mask.
bool is_cut_off(const Region& region, const ImageView& image, const Mask& mask);

}  // namespace sslv
