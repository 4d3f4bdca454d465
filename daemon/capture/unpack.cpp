// SPDX-License-Identifier: Apache-2.0
#include "capture/unpack.h"

#include <algorithm>

namespace sslv {
namespace {

void sixteen_to_8_bit(const std::uint8_t* from, std::size_t pixels, int depth_bits, int high, int low,
                      std::uint8_t* to) noexcept {
  const int shift = std::clamp(depth_bits, 8, 16) - 8;
  for (std::size_t i = 0; i < pixels; ++i) {
    const int value =
        (from[2 * i + static_cast<std::size_t>(high)] << 8 | from[2 * i + static_cast<std::size_t>(low)]) >>
        shift;
    to[i] = static_cast<std::uint8_t>(std::min(value, 255));
  }
}

std::uint8_t joined(std::uint8_t low, int shift, std::uint8_t high) noexcept {
  return static_cast<std::uint8_t>(low >> shift | high << (8 - shift));
}

}  // namespace

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
  sixteen_to_8_bit(from, pixels, depth_bits, 0, 1, to);
}

void little_endian_to_8_bit(const std::uint8_t* from, std::size_t pixels, int depth_bits,
                            std::uint8_t* to) noexcept {
  sixteen_to_8_bit(from, pixels, depth_bits, 1, 0, to);
}

void packed_10p_to_8_bit(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to) noexcept {
  constexpr std::size_t kInGroup = 4;
  for (; pixels > 0; from += 5, to += kInGroup) {
    const std::size_t here = std::min(pixels, kInGroup);
    for (std::size_t i = 0; i < here; ++i) to[i] = joined(from[i], 2 * static_cast<int>(i) + 2, from[i + 1]);
    pixels -= here;
  }
}

void packed_12p_to_8_bit(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to) noexcept {
  for (std::size_t i = 0; i < pixels; ++i) {
    const std::uint8_t* group = from + i / 2 * 3;
    to[i] = i % 2 == 0 ? joined(group[0], 4, group[1]) : group[2];
  }
}

void gige_packed_to_8_bit(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to) noexcept {
  for (std::size_t i = 0; i < pixels; ++i) to[i] = from[i / 2 * 3 + i % 2 * 2];
}

}  // namespace sslv
