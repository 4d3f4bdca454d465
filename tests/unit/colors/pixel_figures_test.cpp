// SPDX-License-Identifier: Apache-2.0
#include "colors/pixel_figures.h"

#include "vision/threshold.h"

#include <algorithm>
#include <array>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sslv::pixel_figures_test {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;

/// 8 x 6 pixels of one colour, with 2 x 2 pixels of another at (4, 2).
struct Scene {
  static constexpr int kWidth = 8, kHeight = 6;
  std::vector<std::uint8_t> bytes;
  ImageView view;

  Scene(PixelFormat format, Rgb ground, Rgb spot) {
    const auto stride = std::ptrdiff_t{kWidth} * bytes_per_pixel(format);
    bytes.resize(static_cast<std::size_t>(stride * kHeight));
    view = {bytes.data(), kWidth, kHeight, stride, format};
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const bool in_spot = (x == 4 || x == 5) && (y == 2 || y == 3);
        put(x, y, in_spot ? spot : ground);
      }
    }
  }
  void put(int x, int y, Rgb color) {
    std::uint8_t* row = bytes.data() + y * view.stride_bytes;
    const Yuv yuv = to_yuv(color);
    const auto bayer = [&](int red_x, int red_y) {
      const bool red = x % 2 == red_x && y % 2 == red_y, blue = x % 2 != red_x && y % 2 != red_y;
      row[x] = red ? color.r : blue ? color.b : color.g;
    };
    switch (view.format) {
      case PixelFormat::kUyvy:
        row[2 * x + 1] = yuv.y;
        row[x / 2 * 4] = yuv.u;
        row[x / 2 * 4 + 2] = yuv.v;
        break;
      case PixelFormat::kYuyv:
        row[2 * x] = yuv.y;
        row[x / 2 * 4 + 1] = yuv.u;
        row[x / 2 * 4 + 3] = yuv.v;
        break;
      case PixelFormat::kRgb24:
        row[3 * x] = color.r;
        row[3 * x + 1] = color.g;
        row[3 * x + 2] = color.b;
        break;
      case PixelFormat::kBgr24:
        row[3 * x] = color.b;
        row[3 * x + 1] = color.g;
        row[3 * x + 2] = color.r;
        break;
      case PixelFormat::kMono8: row[x] = yuv.y; break;
      case PixelFormat::kBayerRg8: bayer(0, 0); break;
      case PixelFormat::kBayerGr8: bayer(1, 0); break;
      case PixelFormat::kBayerGb8: bayer(0, 1); break;
      case PixelFormat::kBayerBg8: bayer(1, 1); break;
    }
  }
};

constexpr Rgb kGround{40, 120, 60}, kSpot{220, 70, 160};
constexpr std::array kColored{PixelFormat::kUyvy,     PixelFormat::kYuyv,     PixelFormat::kRgb24,
                              PixelFormat::kBgr24,    PixelFormat::kBayerRg8, PixelFormat::kBayerGr8,
                              PixelFormat::kBayerGb8, PixelFormat::kBayerBg8};

Lut pink_lut() {
  ColorTable table;
  const Yuv spot = to_yuv(kSpot);
  constexpr int kReach = 6;  // the RGB table is sampled at the centres of its own cells
  for (int y = -kReach; y <= kReach; ++y) {
    for (int u = -kReach; u <= kReach; ++u) {
      for (int v = -kReach; v <= kReach; ++v) {
        const auto level = [](int value) { return static_cast<std::uint8_t>(value); };
        table.labels[table.index(level(spot.y + y), level(spot.u + u), level(spot.v + v))] = label::kPink;
      }
    }
  }
  return Lut(std::move(table));
}

TEST(PixelFigures, ReadTheSameColoursInEveryFormat) {
  for (const PixelFormat format : kColored) {
    const Scene scene(format, kGround, kSpot);
    const PixelBlock block = read_pixels(scene.view, {4, 2, 2, 2}, pink_lut());
    EXPECT_EQ(block.box.x, 4) << name_of(format);
    ASSERT_EQ(block.colors.size(), is_bayer(format) ? 1U : 4U) << name_of(format);
    for (const Yuv color : block.colors) EXPECT_EQ(color, to_yuv(kSpot)) << name_of(format);
    const PixelFigures figures = figures_of(block);
    EXPECT_THAT(figures.mean[0], DoubleNear(to_yuv(kSpot).y, 1e-9)) << name_of(format);
    EXPECT_THAT(figures.spread, ElementsAre(0, 0, 0)) << name_of(format);
    const PixelFigures ground = figures_of(read_pixels(scene.view, {0, 0, 2, 2}, pink_lut()));
    EXPECT_THAT(ground.mean[2], DoubleNear(to_yuv(kGround).v, 1e-9)) << name_of(format);
  }
}

TEST(PixelFigures, GreyPicturesHaveNoColour) {
  const Scene scene(PixelFormat::kMono8, {90, 90, 90}, {200, 200, 200});
  const PixelBlock block = read_pixels(scene.view, {4, 2, 1, 1}, Lut());
  EXPECT_THAT(block.colors, ElementsAre(Yuv{200, 128, 128}));
}

TEST(PixelFigures, LabelsAreTheSegmentations) {
  for (const PixelFormat format : kColored) {
    const Scene scene(format, kGround, kSpot);
    const Lut lut = pink_lut();
    LabelImage labels;
    Threshold().process({}, lut, Mask(), Image(scene.view, nullptr, nullptr, nullptr), labels);
    const PixelBlock block = read_pixels(scene.view, {0, 0, Scene::kWidth, Scene::kHeight}, lut);
    EXPECT_EQ(block.labels, labels.labels) << name_of(format);
  }
}

TEST(PixelFigures, ARectangleIsCutToThePictureAndGrownToCells) {
  const Scene yuv(PixelFormat::kUyvy, kGround, kSpot);
  // An odd x: reading needs the neighbour's chroma, but must not return the neighbour.
  PixelBlock block = read_pixels(yuv.view, {5, 3, 1, 1}, pink_lut());
  EXPECT_EQ(block.columns, 1);
  EXPECT_THAT(block.colors, ElementsAre(to_yuv(kSpot)));
  block = read_pixels(yuv.view, {-3, -2, 5, 4}, pink_lut());
  EXPECT_EQ(block.box.x, 0);
  EXPECT_EQ(block.columns, 2);
  EXPECT_EQ(block.rows, 2);
  block = read_pixels(yuv.view, {7, 5, 100, 100}, pink_lut());
  EXPECT_EQ(block.columns, 1);
  EXPECT_EQ(block.rows, 1);
  for (const PixelBox outside : {PixelBox{8, 0, 4, 4}, {0, 6, 4, 4}, {-4, 0, 4, 4}, {0, -9, 3, 3}})
    EXPECT_TRUE(read_pixels(yuv.view, outside, pink_lut()).colors.empty());

  const Scene bayer(PixelFormat::kBayerGb8, kGround, kSpot);
  block = read_pixels(bayer.view, {5, 3, 1, 1}, pink_lut());
  EXPECT_EQ(block.box.x, 4);
  EXPECT_EQ(block.box.width, 2);
  EXPECT_THAT(block.colors, ElementsAre(to_yuv(kSpot)));
}

TEST(PixelFigures, ARegionIsConnected) {
  Scene scene(PixelFormat::kRgb24, kGround, kSpot);
  scene.put(0, 5, kSpot);  // far from the others
  scene.put(6, 4, kSpot);  // touches at a corner
  const PixelBlock block = read_pixels(scene.view, {0, 0, Scene::kWidth, Scene::kHeight}, pink_lut());
  const auto region = region_around(block, 4, 2);
  EXPECT_EQ(std::count(region.begin(), region.end(), true), 5);
  const PixelFigures figures = figures_of(block, region);
  EXPECT_EQ(figures.count, 5U);
  EXPECT_EQ(figures.cells[label::kPink], 5U);
  EXPECT_EQ(figures.histogram[0][to_yuv(kSpot).y / 4], 5U);
  EXPECT_EQ(figures_of(block, region_around(block, 100, 2)).count, 0U);
}

}  // namespace
}  // namespace sslv::pixel_figures_test
