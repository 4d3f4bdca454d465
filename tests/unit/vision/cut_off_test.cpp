// SPDX-License-Identifier: Apache-2.0
#include "vision/cut_off.h"

#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

namespace sslv::cut_off_test {
namespace {

/// A region that fills this box.
Region box(int left, int top, int right, int bottom) {
  Region region{};
  region.left = static_cast<std::uint16_t>(left);
  region.top = static_cast<std::uint16_t>(top);
  region.right = static_cast<std::uint16_t>(right);
  region.bottom = static_cast<std::uint16_t>(bottom);
  return region;
}
ImageView picture(PixelFormat format) {
  ImageView view;
  view.format = format;
  view.width = 100;
  view.height = 80;
  return view;
}
/// Shows only pixels 20..59 of rows 10..49.
Mask window() {
  MaskSettings settings;
  settings.include = {{{{20, 10}, {60, 10}, {60, 50}, {20, 50}}}};
  return Mask(settings);
}
Mask without(const MaskPolygon& polygon) {
  MaskSettings settings;
  settings.exclude = {polygon};
  return Mask(settings);
}

TEST(CutOff, IsARegionThatTouchesTheMask) {
  const Mask mask = window();
  for (const PixelFormat format : {PixelFormat::kRgb24, PixelFormat::kUyvy}) {
    const ImageView image = picture(format);
    EXPECT_FALSE(is_cut_off(box(30, 20, 40, 30), image, mask));
    EXPECT_FALSE(is_cut_off(box(21, 11, 58, 48), image, mask));
    EXPECT_TRUE(is_cut_off(box(20, 20, 30, 30), image, mask));
    EXPECT_TRUE(is_cut_off(box(50, 20, 59, 30), image, mask));
    EXPECT_TRUE(is_cut_off(box(30, 10, 40, 20), image, mask));
    EXPECT_TRUE(is_cut_off(box(30, 40, 40, 49), image, mask));
    EXPECT_TRUE(is_cut_off(box(20, 10, 59, 49), image, mask));
    // A region of one pixel.
    EXPECT_TRUE(is_cut_off(box(20, 30, 20, 30), image, mask));
    EXPECT_FALSE(is_cut_off(box(21, 30, 21, 30), image, mask));
  }
}

TEST(CutOff, OfBayerQuads) {
  const Mask mask = window();
  const ImageView image = picture(PixelFormat::kBayerRg8);
  EXPECT_FALSE(is_cut_off(box(22, 12, 31, 21), image, mask));
  EXPECT_TRUE(is_cut_off(box(20, 12, 31, 21), image, mask));
  EXPECT_TRUE(is_cut_off(box(50, 20, 59, 31), image, mask));
  EXPECT_FALSE(is_cut_off(box(50, 20, 57, 31), image, mask));
}

TEST(CutOff, NotByThePicturesOwnEdge) {
  for (const PixelFormat format : {PixelFormat::kRgb24, PixelFormat::kBayerRg8}) {
    const ImageView image = picture(format);
    EXPECT_FALSE(is_cut_off(box(0, 0, 11, 11), image, Mask()));
    EXPECT_FALSE(is_cut_off(box(90, 70, 99, 79), image, Mask()));
    const Mask below = without({{{0, 40}, {100, 40}, {100, 80}, {0, 80}}});
    EXPECT_FALSE(is_cut_off(box(0, 0, 11, 11), image, below));
    EXPECT_TRUE(is_cut_off(box(90, 70, 99, 79), image, below));
  }
}

TEST(CutOff, IgnoresTheCornersOfTheBox) {
  // Hides a corner of 10 x 10 px: a disc of radius 10 around (17, 17) does not touch it, but its box does.
  const Mask corner = without({{{0, 0}, {9.5, 0}, {9.5, 9.5}, {0, 9.5}}});
  const ImageView image = picture(PixelFormat::kRgb24);
  EXPECT_FALSE(is_cut_off(box(8, 8, 26, 26), image, corner));
  EXPECT_TRUE(is_cut_off(box(6, 6, 24, 24), image, corner));
}

}  // namespace
}  // namespace sslv::cut_off_test
