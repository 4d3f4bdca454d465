// SPDX-License-Identifier: Apache-2.0
#include "health/exposure.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

namespace sslv::exposure_test {
namespace {

/// An image of 640x480 whose left tenth has `left` in every byte, the rest `rest`.
std::vector<std::uint8_t> two_parts(int bytes_per_px, std::uint8_t left, std::uint8_t rest) {
  const std::size_t row = static_cast<std::size_t>(640) * static_cast<std::size_t>(bytes_per_px);
  std::vector<std::uint8_t> bytes(row * 480, rest);
  for (std::size_t y = 0; y < 480; ++y) std::fill_n(&bytes[y * row], row / 10, left);
  return bytes;
}

TEST(Exposure, TellsClippedAndDarkPixelsInEveryFormat) {
  for (const PixelFormat format : {PixelFormat::kUyvy, PixelFormat::kYuyv, PixelFormat::kRgb24,
                                   PixelFormat::kBgr24, PixelFormat::kMono8, PixelFormat::kBayerRg8}) {
    const int bytes = bytes_per_pixel(format);
    const auto bright = two_parts(bytes, 255, 100);
    const auto clipped = measure_exposure({bright.data(), 640, 480, 640 * bytes, format}, Mask());
    ASSERT_TRUE(clipped);
    EXPECT_NEAR(clipped->clipped_share, 0.1, 0.01) << name_of(format);
    EXPECT_EQ(clipped->dark_share, 0) << name_of(format);
    EXPECT_NEAR(clipped->mean_luma, 115.5, 2) << name_of(format);
    const auto night = two_parts(bytes, 100, 3);
    const auto dark = measure_exposure({night.data(), 640, 480, 640 * bytes, format}, Mask());
    EXPECT_NEAR(dark->dark_share, 0.9, 0.01) << name_of(format);
    EXPECT_EQ(dark->clipped_share, 0) << name_of(format);
  }
}

TEST(Exposure, OneClippedChannelIsEnough) {
  std::vector<std::uint8_t> red(static_cast<std::size_t>(64) * 48 * 3, 40);
  for (std::size_t i = 0; i < red.size(); i += 3) red[i] = 250;
  EXPECT_EQ(measure_exposure({red.data(), 64, 48, 64 * 3, PixelFormat::kRgb24}, Mask())->clipped_share, 1);
}

TEST(Exposure, LooksOnlyAtWhatIsNotMasked) {
  const auto bytes = two_parts(1, 255, 100);
  const ImageView image{bytes.data(), 640, 480, 640, PixelFormat::kMono8};
  MaskSettings settings;
  settings.exclude.push_back({{{0, 0}, {64, 0}, {64, 480}, {0, 480}}});
  EXPECT_EQ(measure_exposure(image, Mask(settings))->clipped_share, 0);
  settings.exclude.push_back({{{0, 0}, {640, 0}, {640, 480}, {0, 480}}});
  EXPECT_FALSE(measure_exposure(image, Mask(settings)));
}

}  // namespace
}  // namespace sslv::exposure_test
