// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"

#include <cstdint>
#include <vector>

namespace sslv {

/// The image as a PNG file (RGB, 8 bits a sample) of every pixel as rgb_at() has it: without loss for RGB,
/// BGR and mono. Of more than 8 bits the upper ones. Throws std::runtime_error when there is no memory for
/// it.
std::vector<std::uint8_t> png_file(const ImageView& image);

}  // namespace sslv
