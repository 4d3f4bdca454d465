// SPDX-License-Identifier: Apache-2.0
#include "vision/label_picture.h"

#include "vision/flood_cut.h"

#include <algorithm>
#include <bit>
#include <cstddef>

namespace sslv {
namespace {

void fill(std::uint8_t* begin, const std::uint8_t* end, Rgb color) {
  for (; begin != end; begin += 3) {
    begin[0] = color.r;
    begin[1] = color.g;
    begin[2] = color.b;
  }
}

/// Draws the first cut label of each block, in a pattern that is not used for anything else.
void draw_floods(const RunList& runs, std::uint8_t* picture, const LabelSet& labels) {
  constexpr int kBlock = FloodCut::kBlockCells;
  const int across = (runs.width + kBlock - 1) / kBlock;
  for (std::size_t i = 0; i < runs.cut.size(); ++i) {
    if (runs.cut[i] == 0) continue;
    // If all labels are cut from a block, the first label would be "clear".
    const std::uint32_t cut = runs.cut[i] & ~(1U << label::kClear);
    const Rgb color = labels.color(static_cast<Label>(std::countr_zero(cut)));
    const int left = static_cast<int>(i) % across * kBlock, top = static_cast<int>(i) / across * kBlock;
    for (int y = top; y < std::min(top + kBlock, runs.height); y += 2) {
      std::uint8_t* const row = picture + std::ptrdiff_t{3} * runs.width * y;
      for (int x = left; x < std::min(left + kBlock, runs.width); x += 2)
        fill(row + std::ptrdiff_t{3} * x, row + std::ptrdiff_t{3} * (x + 1), color);
    }
  }
}

}  // namespace

ImageView draw_label_picture(const RunList& runs, std::vector<std::uint8_t>& buffer, const LabelSet& labels) {
  const std::ptrdiff_t stride_bytes = std::ptrdiff_t{3} * runs.width;
  buffer.resize(static_cast<std::size_t>(stride_bytes) * static_cast<std::size_t>(runs.height));
  fill(buffer.data(), buffer.data() + buffer.size(), labels.color(label::kClear));
  for (const Run& run : runs.runs) {
    std::uint8_t* const row = buffer.data() + run.y * stride_bytes;
    fill(row + 3 * run.x_begin, row + 3 * run.x_end, labels.color(run.label));
  }
  draw_floods(runs, buffer.data(), labels);
  return {buffer.data(), runs.width, runs.height, stride_bytes, PixelFormat::kRgb24};
}

}  // namespace sslv
