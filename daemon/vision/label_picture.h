// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"
#include "vision/regions.h"

#include <cstdint>
#include <vector>

namespace sslv {

/// Draws runs for people: RGB24, one pixel for each cell, in the labels' display colours. Where a label was
/// cut because it floods, every fourth pixel is in its colour. The image lies in `buffer`, which is reused.
ImageView draw_label_picture(const RunList& runs, std::vector<std::uint8_t>& buffer,
                             const LabelSet& labels = LabelSet::built_in());

}  // namespace sslv
