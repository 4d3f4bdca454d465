// SPDX-License-Identifier: Apache-2.0
#include "capture/unpack.h"

#include <algorithm>

namespace sslv {
namespace {

template <int kHigh>
void split_16(const std::uint8_t* __restrict from, std::size_t pixels, int depth_bits,
              std::uint8_t* __restrict to, std::uint8_t* __restrict low) noexcept {
  const int depth = std::clamp(depth_bits, 8, 16);
  const int white = (1 << depth) - 1;
  for (std::size_t i = 0; i < pixels; ++i) {
    const int value = std::min(from[2 * i + kHigh] << 8 | from[2 * i + 1 - kHigh], white) << (16 - depth);
    to[i] = static_cast<std::uint8_t>(value >> 8);
    low[i] = static_cast<std::uint8_t>(value);
  }
}

std::uint8_t byte(int value) noexcept {
  return static_cast<std::uint8_t>(value);
}

/// Calls `split` with each whole group of `kPixels` pixels, and with the incomplete group at the end.
template <std::size_t kPixels, std::size_t kBytes, class Split>
void for_groups(const std::uint8_t* __restrict from, std::size_t pixels, std::uint8_t* __restrict to,
                std::uint8_t* __restrict low, const Split& split) noexcept {
  for (; pixels >= kPixels; pixels -= kPixels, from += kBytes, to += kPixels, low += kPixels)
    split(from, to, low);
  if (pixels == 0) return;
  std::uint8_t group[kBytes]{}, last[2][kPixels];
  std::copy_n(from, (pixels * kBytes + kPixels - 1) / kPixels, group);  // only these bytes were sent
  split(group, last[0], last[1]);
  std::copy_n(last[0], pixels, to);
  std::copy_n(last[1], pixels, low);
}

template <int kLowBits>
void split_gige_packed(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to,
                       std::uint8_t* low) noexcept {
  constexpr int kMask = (1 << kLowBits) - 1;
  for_groups<2, 3>(from, pixels, to, low,
                   [](const std::uint8_t* group, std::uint8_t* upper, std::uint8_t* lower) {
                     upper[0] = group[0];
                     upper[1] = group[2];
                     lower[0] = byte((group[1] & kMask) << (8 - kLowBits));
                     lower[1] = byte((group[1] >> 4 & kMask) << (8 - kLowBits));
                   });
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

void nv12_row_to_uyvy(const std::uint8_t* luma, const std::uint8_t* colors, std::size_t pixels,
                      std::uint8_t* to) noexcept {
  for (std::size_t i = 0; i < pixels; ++i) {
    to[2 * i] = colors[i];
    to[2 * i + 1] = luma[i];
  }
}

void split_big_endian(const std::uint8_t* from, std::size_t pixels, int depth_bits, std::uint8_t* to,
                      std::uint8_t* low) noexcept {
  split_16<0>(from, pixels, depth_bits, to, low);
}

void split_little_endian(const std::uint8_t* from, std::size_t pixels, int depth_bits, std::uint8_t* to,
                         std::uint8_t* low) noexcept {
  split_16<1>(from, pixels, depth_bits, to, low);
}

void split_packed_10p(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to,
                      std::uint8_t* low) noexcept {
  for_groups<4, 5>(from, pixels, to, low,
                   [](const std::uint8_t* group, std::uint8_t* upper, std::uint8_t* lower) {
                     for (int i = 0; i < 4; ++i) {
                       upper[i] = byte(group[i] >> (2 * i + 2) | group[i + 1] << (6 - 2 * i));
                       lower[i] = byte((group[i] >> 2 * i) << 6);
                     }
                   });
}

void split_packed_12p(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to,
                      std::uint8_t* low) noexcept {
  for_groups<2, 3>(from, pixels, to, low,
                   [](const std::uint8_t* group, std::uint8_t* upper, std::uint8_t* lower) {
                     upper[0] = byte(group[0] >> 4 | group[1] << 4);
                     upper[1] = group[2];
                     lower[0] = byte(group[0] << 4);
                     lower[1] = byte(group[1] & 0xF0);
                   });
}

void split_gige_packed_10(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to,
                          std::uint8_t* low) noexcept {
  split_gige_packed<2>(from, pixels, to, low);
}

void split_gige_packed_12(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to,
                          std::uint8_t* low) noexcept {
  split_gige_packed<4>(from, pixels, to, low);
}

}  // namespace sslv
