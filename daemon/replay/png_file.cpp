// SPDX-License-Identifier: Apache-2.0
#include "replay/png_file.h"

#include "image/pixel_at.h"

#include <array>
#include <cstddef>
#include <span>
#include <stdexcept>

#include <zlib.h>

namespace sslv {
namespace {

void add_number(std::uint32_t value, std::vector<std::uint8_t>& out) {
  for (int shift = 24; shift >= 0; shift -= 8) out.push_back(static_cast<std::uint8_t>(value >> shift));
}

/// Appends length, type, data and the CRC of type and data (PNG specification, 5.3).
void add_chunk(const std::array<char, 4>& type, std::span<const std::uint8_t> data,
               std::vector<std::uint8_t>& out) {
  add_number(static_cast<std::uint32_t>(data.size()), out);
  const std::size_t begin = out.size();
  out.insert(out.end(), type.begin(), type.end());
  out.insert(out.end(), data.begin(), data.end());
  const uLong crc = crc32(0, out.data() + begin, static_cast<uInt>(out.size() - begin));
  add_number(static_cast<std::uint32_t>(crc), out);
}

/// Each row begins with its filter type. "Sub" (the difference to the previous pixel) makes camera images a
/// third smaller than no filter.
std::vector<std::uint8_t> filtered_rows(const ImageView& image) {
  constexpr std::uint8_t kSub = 1;
  std::vector<std::uint8_t> rows;
  rows.reserve(static_cast<std::size_t>(image.height) * (1 + 3 * static_cast<std::size_t>(image.width)));
  for (int y = 0; y < image.height; ++y) {
    rows.push_back(kSub);
    Rgb before{0, 0, 0};
    for (int x = 0; x < image.width; ++x) {
      const Rgb now = rgb_at(image, x, y);
      rows.push_back(static_cast<std::uint8_t>(now.r - before.r));
      rows.push_back(static_cast<std::uint8_t>(now.g - before.g));
      rows.push_back(static_cast<std::uint8_t>(now.b - before.b));
      before = now;
    }
  }
  return rows;
}

}  // namespace

std::vector<std::uint8_t> png_file(const ImageView& image) {
  constexpr std::array<std::uint8_t, 8> kSignature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
  constexpr int kLevel = 3;  // higher levels do not make noise smaller
  const std::vector<std::uint8_t> rows = filtered_rows(image);
  uLongf packed_bytes = compressBound(static_cast<uLong>(rows.size()));
  std::vector<std::uint8_t> packed(packed_bytes);
  if (compress2(packed.data(), &packed_bytes, rows.data(), static_cast<uLong>(rows.size()), kLevel) != Z_OK)
    throw std::runtime_error("not enough memory to compress an image");
  packed.resize(packed_bytes);

  std::vector<std::uint8_t> out(kSignature.begin(), kSignature.end());
  std::vector<std::uint8_t> head;
  add_number(static_cast<std::uint32_t>(image.width), head);
  add_number(static_cast<std::uint32_t>(image.height), head);
  head.insert(head.end(),
              {8, 2, 0, 0, 0});  // bits, RGB, the only compression and filter methods, not interlaced
  add_chunk({'I', 'H', 'D', 'R'}, head, out);
  add_chunk({'I', 'D', 'A', 'T'}, packed, out);
  add_chunk({'I', 'E', 'N', 'D'}, {}, out);
  return out;
}

}  // namespace sslv
