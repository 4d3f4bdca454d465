// SPDX-License-Identifier: Apache-2.0
#include "image/color.h"

#include <cmath>
#include <cstdlib>

#include <gtest/gtest.h>

namespace sslv::color_test {
namespace {

// JFIF 1.02, section "Conversion to and from RGB".
TEST(Color, KnownColors) {
  EXPECT_EQ(to_yuv({0, 0, 0}), (Yuv{0, 128, 128}));
  EXPECT_EQ(to_yuv({255, 255, 255}), (Yuv{255, 128, 128}));
  EXPECT_EQ(to_yuv({255, 0, 0}), (Yuv{76, 85, 255}));
  EXPECT_EQ(to_yuv({0, 255, 0}), (Yuv{150, 44, 21}));
  EXPECT_EQ(to_yuv({0, 0, 255}), (Yuv{29, 255, 107}));
  EXPECT_EQ(to_rgb({76, 85, 255}), (Rgb{254, 0, 0}));
  EXPECT_EQ(to_rgb({255, 128, 128}), (Rgb{255, 255, 255}));
}

TEST(Color, GreyHasNoChroma) {
  for (int i = 0; i < 256; ++i) {
    const auto grey = static_cast<std::uint8_t>(i);
    ASSERT_EQ(to_yuv({grey, grey, grey}), (Yuv{grey, 128, 128}));
    ASSERT_EQ(to_rgb({grey, 128, 128}), (Rgb{grey, grey, grey}));
  }
}

template <class Check>
void for_many_colors(Check check) {
  for (int r = 0; r < 256; r += 3) {
    for (int g = 0; g < 256; g += 3) {
      for (int b = 0; b < 256; b += 3) {
        check(Rgb{static_cast<std::uint8_t>(r), static_cast<std::uint8_t>(g), static_cast<std::uint8_t>(b)});
      }
    }
  }
}

TEST(Color, IsRoundedToTheNearest) {
  for_many_colors([](Rgb c) {
    const Yuv yuv = to_yuv(c);
    ASSERT_NEAR(yuv.y, 0.299 * c.r + 0.587 * c.g + 0.114 * c.b, 0.502);
    ASSERT_NEAR(yuv.u, std::min(255.0, 128 - 0.168736 * c.r - 0.331264 * c.g + 0.5 * c.b), 0.502);
    ASSERT_NEAR(yuv.v, std::min(255.0, 128 + 0.5 * c.r - 0.418688 * c.g - 0.081312 * c.b), 0.502);
  });
}

TEST(Color, RoundTripLosesAtMostTwoSteps) {
  for_many_colors([](Rgb c) {
    const Rgb back = to_rgb(to_yuv(c));
    ASSERT_LE(std::abs(back.r - c.r), 2);
    ASSERT_LE(std::abs(back.g - c.g), 2);
    ASSERT_LE(std::abs(back.b - c.b), 2);
  });
}

TEST(Color, ColorsOutsideTheCubeAreClamped) {
  EXPECT_EQ(to_rgb({255, 255, 255}), (Rgb{255, 121, 255}));
  EXPECT_EQ(to_rgb({0, 0, 0}), (Rgb{0, 135, 0}));
}

}  // namespace
}  // namespace sslv::color_test
