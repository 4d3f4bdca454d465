// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"
#include "vision/lut.h"
#include "vision/mask.h"
#include "vision/regions.h"

#include <cstdint>
#include <vector>

namespace sslv {

/// The label of every pixel by this table, run-length encoded as LabelPicture in docs/openapi.json.
std::vector<std::uint8_t> label_image_bytes(const ImageView& image, const Lut& lut, const Mask& mask);
std::vector<std::uint8_t> label_image_bytes(const LabelImage& labels);

}  // namespace sslv
