// SPDX-License-Identifier: Apache-2.0
#include "capture/unpack.h"

#include <vector>

#include <gmock/gmock.h>

namespace sslv::unpack_test {
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

TEST(Unpack, ARowOfNv12TakesTheColoursOfItsPairOfRows) {
  const Bytes luma{1, 2, 3, 4}, colors{10, 20, 30, 40};  // U V U V
  Bytes to(8);
  nv12_row_to_uyvy(luma.data(), colors.data(), 4, to.data());
  EXPECT_EQ(to, (Bytes{10, 1, 20, 2, 30, 3, 40, 4}));
}

/// Results of `split`: 256 times the upper 8 bits of each pixel, plus its low byte.
template <class Split>
std::vector<int> split_values(std::size_t pixels, const Split& split) {
  Bytes to(pixels), low(pixels);
  split(to.data(), low.data());
  std::vector<int> out;
  for (std::size_t i = 0; i < pixels; ++i) out.push_back(to[i] << 8 | low[i]);
  return out;
}

using Values = std::vector<int>;

TEST(Unpack, SixteenBitsAreSplitBelowTheUpperEightOfTheirDepth) {
  const Bytes from{0xAB, 0xCD, 0x0F, 0xF0, 0x00, 0x10};
  const auto split = [&](const std::uint8_t* at, int depth_bits) {
    return [=](std::uint8_t* to, std::uint8_t* low) { split_big_endian(at, 2, depth_bits, to, low); };
  };
  EXPECT_EQ(split_values(2, split(from.data(), 16)), (Values{0xABCD, 0x0FF0}));
  EXPECT_EQ(split_values(2, split(from.data() + 2, 12)), (Values{0xFF00, 0x0100}));
  const Bytes ten{0x03, 0xFF, 0x02, 0x01};
  EXPECT_EQ(split_values(2, split(ten.data(), 10)), (Values{0xFFC0, 0x8040}));
  const Bytes eight{0x00, 0x7F, 0x00, 0xFF};
  EXPECT_EQ(split_values(2, split(eight.data(), 8)), (Values{0x7F00, 0xFF00}));
}

TEST(Unpack, MoreThanTheDepthIsWhite) {
  const Bytes from{0x10, 0x00};
  EXPECT_EQ(split_values(1, [&](std::uint8_t* to,
                                std::uint8_t* low) { split_big_endian(from.data(), 1, 12, to, low); }),
            Values{0xFFF0});
}

TEST(Unpack, TheLowByteMayComeFirst) {
  const Bytes from{0xCD, 0xAB, 0xF1, 0x0F, 0x00, 0x10};
  const auto split = [&](int depth_bits) {
    return [=, &from](std::uint8_t* to, std::uint8_t* low) {
      split_little_endian(from.data(), 3, depth_bits, to, low);
    };
  };
  EXPECT_EQ(split_values(3, split(16)), (Values{0xABCD, 0x0FF1, 0x1000}));
  EXPECT_EQ(split_values(3, split(12)), (Values{0xFFF0, 0xFF10, 0xFFF0}));
}

/// Packs pixels one after the other, lowest bits first.
Bytes packed_p(const std::vector<int>& values, std::size_t bits) {
  Bytes out((values.size() * bits + 7) / 8);
  for (std::size_t i = 0; i < values.size() * bits; ++i) {
    const int bit = values[i / bits] >> (i % bits) & 1;
    out[i / 8] = static_cast<std::uint8_t>(out[i / 8] | bit << (i % 8));
  }
  return out;
}

TEST(Unpack, PackedPixelsKeepAllTheirBits) {
  // Six pixels: one and a half groups of "10p".
  const Values ten{0x2AF, 0x155, 0x3FF, 0x000, 0x1C3, 0x23D};
  Bytes from = packed_p(ten, 10);
  from.resize(8);  // the camera sends no more, so no more may be read
  const Values tens = split_values(
      6, [&](std::uint8_t* to, std::uint8_t* low) { split_packed_10p(from.data(), 6, to, low); });
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(tens[i], ten[i] << 6) << i;

  const Values twelve{0xABC, 0x123, 0xFFF, 0x00F, 0xF10};
  from = packed_p(twelve, 12);
  from.resize(8);
  const Values twelves = split_values(
      5, [&](std::uint8_t* to, std::uint8_t* low) { split_packed_12p(from.data(), 5, to, low); });
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(twelves[i], twelve[i] << 4) << i;

  const Bytes gige{0xAB, 0x3C, 0x12, 0xFF, 0x02, 0x00};
  EXPECT_EQ(split_values(4, [&](std::uint8_t* to,
                                std::uint8_t* low) { split_gige_packed_12(gige.data(), 4, to, low); }),
            (Values{0xABC0, 0x1230, 0xFF20, 0x0000}));
  // The middle byte has the two low bits of one pixel in its lower half, of the other in its upper half.
  EXPECT_EQ(split_values(4, [&](std::uint8_t* to,
                                std::uint8_t* low) { split_gige_packed_10(gige.data(), 4, to, low); }),
            (Values{0xAB00, 0x12C0, 0xFF80, 0x0000}));
}

}  // namespace
}  // namespace sslv::unpack_test
