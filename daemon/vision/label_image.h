// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"
#include "vision/lut.h"
#include "vision/mask.h"
#include "vision/regions.h"

#include <cstdint>
#include <vector>

namespace sslv {

/// docs/openapi.json's LabelPicture: every pixel's label by this table, run-length encoded.
std::vector<std::uint8_t> label_image_bytes(const ImageView& image, const Lut& lut, const Mask& mask);
std::vector<std::uint8_t> label_image_bytes(const LabelImage& labels);

}  // namespace sslv
