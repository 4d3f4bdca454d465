// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"

#include <cstdint>
#include <vector>

namespace sslv {

/// Encodes the image as a PNG file (RGB, 8 bits a sample) with each pixel from rgb_at(): lossless for RGB,
/// BGR and mono; the upper 8 bits of larger samples. Throws std::runtime_error if memory is short.
std::vector<std::uint8_t> png_file(const ImageView& image);

}  // namespace sslv
