// SPDX-License-Identifier: Apache-2.0
#include "calibration/line_picture.h"

#include "calibration/measure_lines.h"
#include "image/color.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace sslv::line_picture_test {
namespace {

struct Drawn {
  std::vector<std::uint8_t> bytes;
  ImageView view;
};

/// A carpet with a stripe from left to right, its middle at `middle_y` at x = 0, rising by `slope`.
Drawn stripe(double middle_y, double slope, double width_px, Rgb paint, double noise) {
  constexpr int kWidth = 120, kHeight = 90, kSamples = 8;
  Drawn out;
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0, noise);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      double share = 0;
      for (int j = 0; j < kSamples; ++j) {
        for (int i = 0; i < kSamples; ++i) {
          const double sx = x + (i + 0.5) / kSamples - 0.5, sy = y + (j + 0.5) / kSamples - 0.5;
          const double across = (sy - middle_y - slope * sx) / std::hypot(1, slope);
          // Blurred edges.
          share += (std::erf((across + width_px / 2) / 0.9) - std::erf((across - width_px / 2) / 0.9)) / 2;
        }
      }
      share /= kSamples * kSamples;
      const auto mix = [&](double ground, double line) {
        const double value = ground + share * (line - ground) + (noise > 0 ? normal(random) : 0);
        return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
      };
      out.bytes.push_back(mix(34, paint.r));
      out.bytes.push_back(mix(98, paint.g));
      out.bytes.push_back(mix(48, paint.b));
    }
  }
  out.view = {out.bytes.data(), kWidth, kHeight, kWidth * 3, PixelFormat::kRgb24};
  return out;
}

LinePicture lines_of(const Drawn& drawn) {
  MeanPicture mean;
  EXPECT_TRUE(mean.add(drawn.view));
  return find_line_pixels(mean, 3);
}

TEST(LinePicture, FindsAWhiteStripe) {
  const LinePicture picture = lines_of(stripe(40, 0.1, 3, {205, 208, 200}, 4));
  EXPECT_GT(picture.line.row(46)[60], picture.min_line);
  EXPECT_LT(picture.line.row(20)[60], picture.min_line);
  EXPECT_NEAR(picture.noise, 4 / std::sqrt(3.0), 0.5);
}

TEST(LinePicture, LeavesOutAColouredStripe) {
  const LinePicture picture = lines_of(stripe(40, 0, 3, {235, 105, 25}, 0));
  EXPECT_EQ(picture.line.row(40)[60], 0);
}

TEST(LinePicture, KnowsTheDistanceToTheNearestStripe) {
  const LinePicture picture = lines_of(stripe(40, 0.3, 3, {205, 208, 200}, 4));
  for (const auto& [x, y] : {std::pair{20, 10}, {60, 70}, {100, 80}, {5, 88}, {60, 58}}) {
    double nearest = 1e9;
    for (int v = 0; v < picture.height(); ++v) {
      for (int u = 0; u < picture.width(); ++u) {
        if (picture.line.row(v)[u] > picture.min_line) nearest = std::min(nearest, std::hypot(u - x, v - y));
      }
    }
    EXPECT_NEAR(picture.distance_px.row(y)[x], nearest, 1e-3) << x << " " << y;
  }
}

TEST(MeanPicture, TakesAllFormatsAlike) {
  const Drawn rgb = stripe(40, 0.1, 6, {205, 208, 200}, 0);
  const int width = rgb.view.width, height = rgb.view.height;
  std::vector<std::uint8_t> uyvy, bayer;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const std::uint8_t* pixel = rgb.view.row(y) + 3 * x;
      const Yuv yuv = to_yuv({pixel[0], pixel[1], pixel[2]});
      uyvy.push_back(x % 2 == 0 ? yuv.u : yuv.v);
      uyvy.push_back(yuv.y);
      bayer.push_back(pixel[x % 2 == 0 && y % 2 == 0 ? 0 : x % 2 == 1 && y % 2 == 1 ? 2 : 1]);
    }
  }
  MeanPicture from_rgb, from_uyvy, from_bayer;
  ASSERT_TRUE(from_rgb.add(rgb.view));
  ASSERT_TRUE(from_uyvy.add({uyvy.data(), width, height, width * 2, PixelFormat::kUyvy}));
  ASSERT_TRUE(from_bayer.add({bayer.data(), width, height, width, PixelFormat::kBayerRg8}));
  for (std::size_t c = 0; c < 3; ++c) {
    const FloatPicture a = from_rgb.channel(c), b = from_uyvy.channel(c), d = from_bayer.channel(c);
    for (const int y : {10, 46, 80}) {  // carpet and the stripe's middle
      EXPECT_NEAR(a.row(y)[60], b.row(y)[60], 3) << c << " " << y;
      EXPECT_NEAR(a.row(y)[60], d.row(y)[60], 3) << c << " " << y;
    }
  }
}

TEST(MeanPicture, RefusesFramesOfAnotherSizeOrWithoutColours) {
  const Drawn rgb = stripe(40, 0, 3, {205, 208, 200}, 0);
  MeanPicture mean;
  EXPECT_FALSE(mean.add({rgb.bytes.data(), 100, 90, 100, PixelFormat::kMono8}));
  EXPECT_TRUE(mean.add(rgb.view));
  EXPECT_FALSE(mean.add({rgb.bytes.data(), 100, 90, 300, PixelFormat::kRgb24}));
  EXPECT_EQ(mean.frames(), 1);
}

TEST(MeasureLine, FindsTheMiddleToAFewHundredthsOfAPixel) {
  for (const double offset : {-0.7, -0.3, 0.0, 0.2, 0.6}) {
    const LinePicture picture = lines_of(stripe(44.3, 0.2, 2.2, {205, 208, 200}, 2));
    const double slope = 0.2, scale = std::hypot(1, slope);
    ExpectedLine expected;
    expected.normal = Eigen::Vector2d(-slope, 1) / scale;
    expected.pixel = Eigen::Vector2d(60, 44.3 + slope * 60) - offset * expected.normal;
    expected.width_px = 2.2;
    const auto measured = measure_line(picture, expected, 0.7);
    ASSERT_TRUE(measured) << offset;
    EXPECT_NEAR(measured->offset_px, offset, 0.03);
    EXPECT_LT(measured->sigma_px, 0.02);
    EXPECT_NEAR(measured->contrast, 144, 30);
  }
}

TEST(MeasureLine, FindsNothingOnBareCarpet) {
  const LinePicture picture = lines_of(stripe(10, 0, 2, {205, 208, 200}, 2));
  ExpectedLine expected;
  expected.pixel = {60, 60};
  expected.normal = {0, 1};
  expected.width_px = 2;
  const auto measured = measure_line(picture, expected, 0.7);
  EXPECT_TRUE(!measured || measured->contrast < 4 * picture.noise);
}

}  // namespace
}  // namespace sslv::line_picture_test
