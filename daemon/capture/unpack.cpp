// SPDX-License-Identifier: Apache-2.0
#include "capture/unpack.h"

#include <algorithm>

namespace sslv {

void yuv411_to_uyvy(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to) noexcept {
  for (const std::uint8_t* const end = from + pixels / 4 * 6; from < end; from += 6, to += 8) {
    const std::uint8_t u = from[0], v = from[3];
    to[0] = u;
    to[1] = from[1];
    to[2] = v;
    to[3] = from[2];
    to[4] = u;
    to[5] = from[4];
    to[6] = v;
    to[7] = from[5];
  }
}

void yuv444_to_uyvy(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to) noexcept {
  const auto mean = [](int a, int b) { return static_cast<std::uint8_t>((a + b + 1) / 2); };
  for (const std::uint8_t* const end = from + pixels / 2 * 6; from < end; from += 6, to += 4) {
    to[0] = mean(from[0], from[3]);
    to[1] = from[1];
    to[2] = mean(from[2], from[5]);
    to[3] = from[4];
  }
}

void big_endian_to_8_bit(const std::uint8_t* from, std::size_t pixels, int depth_bits,
                         std::uint8_t* to) noexcept {
  const int shift = std::clamp(depth_bits, 8, 16) - 8;
  for (std::size_t i = 0; i < pixels; ++i) {
    const int value = (from[2 * i] << 8 | from[2 * i + 1]) >> shift;
    to[i] = static_cast<std::uint8_t>(std::min(value, 255));
  }
}

}  // namespace sslv
