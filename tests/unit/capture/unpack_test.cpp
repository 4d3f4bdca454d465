// SPDX-License-Identifier: Apache-2.0
#include "capture/unpack.h"

#include <vector>

#include <gmock/gmock.h>

namespace sslv {
namespace {

using Bytes = std::vector<std::uint8_t>;

TEST(Unpack, FourPixelsOfYuv411ShareTheirColour) {
  // Two groups: U Y0 Y1 V Y2 Y3.
  const Bytes from{10, 1, 2, 20, 3, 4, 30, 5, 6, 40, 7, 8};
  Bytes to(16);
  yuv411_to_uyvy(from.data(), 8, to.data());
  EXPECT_EQ(to, (Bytes{10, 1, 20, 2, 10, 3, 20, 4, 30, 5, 40, 6, 30, 7, 40, 8}));
}

TEST(Unpack, TwoPixelsOfYuv444GetTheirMeanColour) {
  const Bytes from{10, 1, 100, 20, 2, 201, 255, 3, 0, 255, 4, 1};
  Bytes to(8);
  yuv444_to_uyvy(from.data(), 4, to.data());
  EXPECT_EQ(to, (Bytes{15, 1, 151, 2, 255, 3, 1, 4}));
}

TEST(Unpack, SixteenBitsKeepTheUpperEightOfTheirDepth) {
  const Bytes from{0xAB, 0xCD, 0x0F, 0xF0, 0x00, 0x10};
  Bytes to(3);
  big_endian_to_8_bit(from.data(), 3, 16, to.data());
  EXPECT_EQ(to, (Bytes{0xAB, 0x0F, 0x00}));
  big_endian_to_8_bit(from.data() + 2, 2, 12, to.data());
  EXPECT_EQ(to, (Bytes{0xFF, 0x01, 0x00}));
  const Bytes low{0x00, 0x7F};
  big_endian_to_8_bit(low.data(), 1, 8, to.data());
  EXPECT_EQ(to[0], 0x7F);
}

TEST(Unpack, MoreThanTheDepthIsWhite) {
  const Bytes from{0x10, 0x00};
  Bytes to(1);
  big_endian_to_8_bit(from.data(), 1, 12, to.data());
  EXPECT_EQ(to[0], 255);
}

TEST(Unpack, TheLowByteMayComeFirst) {
  const Bytes from{0xCD, 0xAB, 0xF0, 0x0F, 0x00, 0x10};
  Bytes to(3);
  little_endian_to_8_bit(from.data(), 3, 16, to.data());
  EXPECT_EQ(to, (Bytes{0xAB, 0x0F, 0x10}));
  little_endian_to_8_bit(from.data(), 3, 12, to.data());
  EXPECT_EQ(to, (Bytes{0xFF, 0xFF, 0xFF}));
  little_endian_to_8_bit(from.data() + 2, 1, 12, to.data());
  EXPECT_EQ(to[0], 0xFF);
}

/// Pixels one after the other, the lowest bit of each first.
Bytes packed_p(const std::vector<int>& values, std::size_t bits) {
  Bytes out((values.size() * bits + 7) / 8);
  for (std::size_t i = 0; i < values.size() * bits; ++i) {
    const int bit = values[i / bits] >> (i % bits) & 1;
    out[i / 8] = static_cast<std::uint8_t>(out[i / 8] | bit << (i % 8));
  }
  return out;
}

TEST(Unpack, PackedPixelsKeepTheirUpperEightBits) {
  // Six: a group and a half of "10p".
  const std::vector<int> ten{0x2AF, 0x155, 0x3FF, 0x000, 0x1C3, 0x23D};
  Bytes from = packed_p(ten, 10);
  Bytes to(6);
  packed_10p_to_8_bit(from.data(), 6, to.data());
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(to[i], ten[i] >> 2) << i;

  const std::vector<int> twelve{0xABC, 0x123, 0xFFF, 0x00F, 0xF10, 0x7E8};
  from = packed_p(twelve, 12);
  packed_12p_to_8_bit(from.data(), 6, to.data());
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(to[i], twelve[i] >> 4) << i;

  const Bytes gige{0xAB, 0x3C, 0x12, 0xFF, 0x0F, 0x00};
  gige_packed_to_8_bit(gige.data(), 4, to.data());
  EXPECT_EQ((Bytes{to.begin(), to.begin() + 4}), (Bytes{0xAB, 0x12, 0xFF, 0x00}));
}

}  // namespace
}  // namespace sslv
