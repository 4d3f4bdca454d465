// SPDX-License-Identifier: Apache-2.0
#include "image/pixel_at.h"

#include <vector>

#include <gmock/gmock.h>

namespace sslv::pixel_at_test {
namespace {

using testing::ElementsAre;

ImageView view_of(const std::vector<std::uint8_t>& bytes, PixelFormat format, int width, int height,
                  std::ptrdiff_t stride_bytes) {
  return {bytes.data(), width, height, stride_bytes, format};
}

TEST(PixelAt, ReadsRgbAndBgrWhereTheyLie) {
  const std::vector<std::uint8_t> bytes{1, 2, 3, 4, 5, 6, 0, 7, 8, 9, 10, 11, 12, 0};
  EXPECT_EQ(rgb_at(view_of(bytes, PixelFormat::kRgb24, 2, 2, 7), 1, 1), (Rgb{10, 11, 12}));
  EXPECT_EQ(rgb_at(view_of(bytes, PixelFormat::kBgr24, 2, 2, 7), 0, 1), (Rgb{9, 8, 7}));
}

TEST(PixelAt, TwoPixelsOfYuvShareTheirColor) {
  const std::vector<std::uint8_t> uyvy{90, 50, 160, 60}, yuyv{50, 90, 60, 160};
  for (const auto& [bytes, format] : {std::pair(uyvy, PixelFormat::kUyvy), {yuyv, PixelFormat::kYuyv}}) {
    const ImageView image = view_of(bytes, format, 2, 1, 4);
    EXPECT_EQ(rgb_at(image, 0, 0), to_rgb({50, 90, 160}));
    EXPECT_EQ(rgb_at(image, 1, 0), to_rgb({60, 90, 160}));
    EXPECT_EQ(grey_at(image, 1, 0), 60);
  }
}

TEST(PixelAt, MonoIsGrey) {
  const std::vector<std::uint8_t> bytes{17};
  const ImageView image = view_of(bytes, PixelFormat::kMono8, 1, 1, 1);
  EXPECT_EQ(rgb_at(image, 0, 0), (Rgb{17, 17, 17}));
  EXPECT_EQ(grey_at(image, 0, 0), 17);
}

TEST(PixelAt, BayerIsLinearBetweenSamples) {
  // Red increases to the right, green decreases downwards, blue is constant.
  constexpr int kWidth = 6, kHeight = 4;
  const auto red = [](int x) { return 40 + 10 * x; };
  const auto green = [](int y) { return 200 - 20 * y; };
  constexpr int kBlue = 90;
  for (const PixelFormat format :
       {PixelFormat::kBayerRg8, PixelFormat::kBayerGr8, PixelFormat::kBayerGb8, PixelFormat::kBayerBg8}) {
    std::vector<std::uint8_t> bytes;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const std::size_t color = bayer_color(format, x, y);
        bytes.push_back(static_cast<std::uint8_t>(color == 0 ? red(x) : color == 1 ? green(y) : kBlue));
      }
    const ImageView image = view_of(bytes, format, kWidth, kHeight, kWidth);
    for (int y = 1; y < kHeight - 1; ++y)
      for (int x = 1; x < kWidth - 1; ++x) {
        const Rgb found = rgb_at(image, x, y);
        EXPECT_EQ(found, (Rgb{static_cast<std::uint8_t>(red(x)), static_cast<std::uint8_t>(green(y)), kBlue}))
            << name_of(format) << ' ' << x << ' ' << y;
        EXPECT_EQ(grey_at(image, x, y), to_yuv(found).y);
      }
    EXPECT_EQ(rgb_at(image, 0, 0).b, kBlue) << "at the edge, too";
    EXPECT_EQ(rgb_at(image, kWidth - 1, kHeight - 1).b, kBlue);
  }
}

TEST(PixelAt, BayerIsNamedAfterItsFirstPixels) {
  EXPECT_EQ(bayer_color(PixelFormat::kBayerRg8, 0, 0), 0U);
  EXPECT_EQ(bayer_color(PixelFormat::kBayerRg8, 1, 0), 1U);
  EXPECT_EQ(bayer_color(PixelFormat::kBayerGr8, 0, 0), 1U);
  EXPECT_EQ(bayer_color(PixelFormat::kBayerGr8, 1, 0), 0U);
  EXPECT_EQ(bayer_color(PixelFormat::kBayerGb8, 0, 0), 1U);
  EXPECT_EQ(bayer_color(PixelFormat::kBayerGb8, 1, 0), 2U);
  EXPECT_EQ(bayer_color(PixelFormat::kBayerBg8, 0, 0), 2U);
  EXPECT_EQ(bayer_color(PixelFormat::kBayerBg8, 1, 1), 0U);
}

TEST(PixelAt, CopiesTheGreyOfAllPixels) {
  const std::vector<std::uint8_t> bytes{1, 2, 0, 3, 4, 0};
  std::vector<std::uint8_t> grey(1);
  copy_grey(view_of(bytes, PixelFormat::kMono8, 2, 2, 3), grey);
  EXPECT_THAT(grey, ElementsAre(1, 2, 3, 4));
}

}  // namespace
}  // namespace sslv::pixel_at_test
