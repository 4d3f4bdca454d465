// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"

#include <string>

namespace sslv {

// Both paths label groups of 16 cells of one row. A group's bytes are whole texels of 16 bytes, four words
// each, and so are its labels. Bytes lie in words as on the CPU, the first one lowest. All arithmetic is of
// whole numbers, so that every GPU says what the CPU says.
inline constexpr int kCellsAGroup = 16, kTexelBytes = 16;

/// Texels of a group in one row of the image.
constexpr int texels_a_group(PixelFormat format) {
  return is_bayer(format) ? 2 : bytes_per_pixel(format);
}
/// Rows of the image in one row of cells.
constexpr int rows_a_cell(PixelFormat format) {
  return is_bayer(format) ? 2 : 1;
}

/// Invocations of a compute shader's work group.
inline constexpr int kWorkGroup = 128;
/// Bindings of shader storage.
inline constexpr int kImageBuffer = 0, kTableBuffer = 1, kLabelBuffer = 2;
/// Words of a table in one row of its texture: the smallest size that every GPU has.
inline constexpr int kTableTextureWidth = 2048;

/// GLSL ES 3.10, over buffers. Uniforms: group_count, groups_a_row. The table has `bits` a channel.
std::string threshold_compute_shader(PixelFormat format, int bits);
/// GLSL ES 3.00: a triangle over all; textures `image` and `table`, one fragment a group.
std::string threshold_vertex_shader();
std::string threshold_fragment_shader(PixelFormat format, int bits);

}  // namespace sslv
