// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"

#include <string>

namespace sslv {

// The shader labels groups of 16 cells of one row. A group's pixels and its labels each fill whole texels of
// 16 bytes (four words). Words are little-endian, as on the CPU. All arithmetic is in integers, so that every
// GPU gives the CPU's results.
inline constexpr int kCellsAGroup = 16, kTexelBytes = 16;

/// Texels of a group in one image row.
constexpr int texels_a_group(PixelFormat format) {
  return is_bayer(format) ? 2 : bytes_per_pixel(format);
}
/// Image rows per row of cells.
constexpr int rows_a_cell(PixelFormat format) {
  return is_bayer(format) ? 2 : 1;
}

/// Invocations per compute work group.
inline constexpr int kWorkGroup = 128;
/// Bindings of the shader storage buffers.
inline constexpr int kImageBuffer = 0, kTableBuffer = 1, kLabelBuffer = 2;

/// GLSL ES 3.10, over buffers. Uniforms: group_count, groups_a_row. The table has `bits` per channel.
std::string threshold_shader(PixelFormat format, int bits);

}  // namespace sslv
