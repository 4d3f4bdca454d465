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

}  // namespace
}  // namespace sslv
