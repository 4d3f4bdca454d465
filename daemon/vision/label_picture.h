// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"
#include "vision/regions.h"

#include <cstdint>
#include <vector>

namespace sslv {

/// Draws runs for viewing: RGB24, one pixel for each cell, in the labels' display colours. In blocks from
/// which a label was cut (FloodCut), every fourth pixel has the label's colour. The image lies in `buffer`,
/// which is reused.
ImageView draw_label_picture(const RunList& runs, std::vector<std::uint8_t>& buffer,
                             const LabelSet& labels = LabelSet::built_in());

}  // namespace sslv
