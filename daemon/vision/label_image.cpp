// SPDX-License-Identifier: Apache-2.0
#include "vision/label_image.h"

#include "vision/threshold.h"

#include <cstddef>

namespace sslv {

std::vector<std::uint8_t> label_image_bytes(const ImageView& image, const Lut& lut, const Mask& mask) {
  LabelImage labels;
  Threshold().process({}, lut, mask, Image(image, nullptr, nullptr, nullptr), labels);
  return label_image_bytes(labels);
}

std::vector<std::uint8_t> label_image_bytes(const LabelImage& labels) {
  std::vector<std::uint8_t> out;
  for (const int size : {labels.width, labels.height}) {
    out.push_back(static_cast<std::uint8_t>(size & 0xFF));
    out.push_back(static_cast<std::uint8_t>(size >> 8 & 0xFF));
  }
  for (std::size_t begin = 0; begin < labels.labels.size();) {
    const Label label = labels.labels[begin];
    std::size_t end = begin + 1;
    while (end < labels.labels.size() && labels.labels[end] == label) ++end;
    out.push_back(label);
    std::size_t length = end - begin;
    for (; length > 0x7F; length >>= 7) out.push_back(static_cast<std::uint8_t>(length | 0x80));
    out.push_back(static_cast<std::uint8_t>(length));
    begin = end;
  }
  return out;
}

}  // namespace sslv
