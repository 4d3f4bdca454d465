// SPDX-License-Identifier: Apache-2.0
#include "vision/label_picture.h"

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

}  // namespace

ImageView draw_label_picture(const RunList& runs, std::vector<std::uint8_t>& buffer, const LabelSet& labels) {
  const std::ptrdiff_t stride_bytes = std::ptrdiff_t{3} * runs.width;
  buffer.resize(static_cast<std::size_t>(stride_bytes) * static_cast<std::size_t>(runs.height));
  fill(buffer.data(), buffer.data() + buffer.size(), labels.color(label::kClear));
  for (const Run& run : runs.runs) {
    std::uint8_t* const row = buffer.data() + run.y * stride_bytes;
    fill(row + 3 * run.x_begin, row + 3 * run.x_end, labels.color(run.label));
  }
  return {buffer.data(), runs.width, runs.height, stride_bytes, PixelFormat::kRgb24};
}

}  // namespace sslv
