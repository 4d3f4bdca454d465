// SPDX-License-Identifier: Apache-2.0
// threshold -> find_runs -> find_regions, compared with a flood fill that does not use runs.
#include "vision/find_regions.h"
#include "vision/find_runs.h"
#include "vision/threshold.h"

#include <map>
#include <random>
#include <tuple>

#include <gmock/gmock.h>

namespace sslv::segmentation_test {
namespace {

using ::testing::ElementsAre;

LabelImage random_labels(std::mt19937& random, int width, int height, int cell_px) {
  LabelImage image{width, height, cell_px, {}};
  std::uniform_int_distribution<int> label(0, 5);
  for (int i = 0; i < width * height; ++i) {
    const int drawn = label(random);
    image.labels.push_back(static_cast<Label>(drawn < 3 ? 0 : drawn));
  }
  return image;
}

/// A region, independent of the order in which it was found: label, cells, sum of x, sum of y, box.
using Blob = std::tuple<int, int, long, long, int, int, int, int>;

std::vector<Blob> flood_fill(const LabelImage& image, bool eight) {
  std::vector<Blob> blobs;
  LabelImage left = image;
  for (int y0 = 0; y0 < image.height; ++y0) {
    for (int x0 = 0; x0 < image.width; ++x0) {
      const Label label = left.row(y0)[x0];
      if (label == 0) continue;
      int cells = 0, min_x = x0, min_y = y0, max_x = x0, max_y = y0;
      long sum_x = 0, sum_y = 0;
      std::vector<std::pair<int, int>> open{{x0, y0}};
      left.row(y0)[x0] = 0;
      while (!open.empty()) {
        const auto [x, y] = open.back();
        open.pop_back();
        ++cells;
        sum_x += x;
        sum_y += y;
        min_x = std::min(min_x, x), max_x = std::max(max_x, x);
        min_y = std::min(min_y, y), max_y = std::max(max_y, y);
        for (int dy = -1; dy <= 1; ++dy) {
          for (int dx = -1; dx <= 1; ++dx) {
            if (!eight && dx != 0 && dy != 0) continue;
            const int nx = x + dx, ny = y + dy;
            if (nx < 0 || ny < 0 || nx >= image.width || ny >= image.height || left.row(ny)[nx] != label)
              continue;
            left.row(ny)[nx] = 0;
            open.emplace_back(nx, ny);
          }
        }
      }
      blobs.emplace_back(label, cells, sum_x, sum_y, min_x, min_y, max_x, max_y);
    }
  }
  std::sort(blobs.begin(), blobs.end());
  return blobs;
}

std::vector<Blob> blobs_of(const RegionList& regions, int cell_px) {
  std::vector<Blob> blobs;
  const double offset = (cell_px - 1) * 0.5;
  for (const Region& r : regions.regions) {
    const int cells = static_cast<int>(r.area_px) / (cell_px * cell_px);
    blobs.emplace_back(r.label, cells, std::lround((r.x_px - offset) / cell_px * cells),
                       std::lround((r.y_px - offset) / cell_px * cells), r.left / cell_px, r.top / cell_px,
                       r.right / cell_px, r.bottom / cell_px);
  }
  std::sort(blobs.begin(), blobs.end());
  return blobs;
}

TEST(Segmentation, EqualsFloodFillOnRandomPictures) {
  std::mt19937 random(1);
  FindRuns find_runs;
  FindRegions find_regions;
  RunList runs;
  RegionList regions;
  for (int i = 0; i < 400; ++i) {
    // Too small for any label to count as a flood.
    const int width = 1 + static_cast<int>(random() % 40), height = 1 + static_cast<int>(random() % 8);
    const int cell_px = 1 + i % 2;
    const LabelImage labels = random_labels(random, width, height, cell_px);
    FindRegions::Params params;
    params.min_cells = 1;
    params.connectivity = i % 4 < 2 ? Connectivity::kFour : Connectivity::kEight;
    find_runs.process({}, labels, runs);
    find_regions.process(params, runs, regions);
    ASSERT_EQ(blobs_of(regions, cell_px), flood_fill(labels, params.connectivity == Connectivity::kEight))
        << width << " x " << height << ", picture " << i;
    ASSERT_FALSE(regions.capped);
  }
}

TEST(Segmentation, SortsByLabelThenArea) {
  LabelImage labels{7,
                    2,
                    1,
                    {5, 5, 0, 3, 0, 5, 5,  //
                     0, 0, 0, 3, 0, 5, 5}};
  RunList runs;
  RegionList regions;
  FindRuns().process({}, labels, runs);
  FindRegions::Params params;
  params.min_cells = 1;
  FindRegions().process(params, runs, regions);
  ASSERT_EQ(regions.regions.size(), 3u);
  EXPECT_EQ(regions.of(3).size(), 1u);
  EXPECT_EQ(regions.of(4).size(), 0u);
  ASSERT_EQ(regions.of(5).size(), 2u);
  EXPECT_EQ(regions.of(5)[0].area_px, 4u);
  EXPECT_FLOAT_EQ(regions.of(5)[0].x_px, 5.5f);
  EXPECT_FLOAT_EQ(regions.of(5)[0].y_px, 0.5f);
  EXPECT_EQ(regions.of(5)[1].area_px, 2u);
}

TEST(Segmentation, CellsOfBayerPicturesCountAsFourPixels) {
  LabelImage labels{3,
                    2,
                    2,
                    {0, 5, 0,  //
                     0, 5, 0}};
  RunList runs;
  RegionList regions;
  FindRuns().process({}, labels, runs);
  FindRegions().process({}, runs, regions);
  ASSERT_EQ(regions.regions.size(), 1u);
  const Region& r = regions.regions[0];
  EXPECT_EQ(r.area_px, 8u);
  EXPECT_FLOAT_EQ(r.x_px, 2.5f);
  EXPECT_FLOAT_EQ(r.y_px, 1.5f);
  EXPECT_THAT((std::vector<int>{r.left, r.top, r.right, r.bottom}), ElementsAre(2, 0, 3, 3));
}

TEST(Segmentation, KeepsTheLargestRegionsAtTheCap) {
  LabelImage labels{1000, 1, 1, std::vector<Label>(1000, 0)};
  for (int i = 0; i < 900; i += 3) labels.labels[static_cast<std::size_t>(i)] = 2;
  for (int i = 950; i < 960; ++i) labels.labels[static_cast<std::size_t>(i)] = 2;
  RunList runs;
  RegionList regions;
  FindRuns().process({}, labels, runs);
  FindRegions::Params params;
  params.min_cells = 1;
  params.max_regions = 100;
  FindRegions().process(params, runs, regions);
  EXPECT_TRUE(regions.capped);
  ASSERT_EQ(regions.of(2).size(), 100u);
  EXPECT_EQ(regions.of(2)[0].area_px, 10u);
}

// ---- threshold

std::shared_ptr<const Lut> lut_with(std::initializer_list<std::pair<Rgb, Label>> colors) {
  std::vector<Label> table(Lut::kEntries, label::kClear);
  for (const auto& [rgb, label] : colors) {
    const Yuv c = to_yuv(rgb);
    // A small box, because the RGB table rounds.
    for (int y = -4; y <= 4; ++y) {
      for (int u = -4; u <= 4; ++u) {
        for (int v = -4; v <= 4; ++v) {
          const auto byte = [](int value) { return static_cast<std::uint8_t>(std::clamp(value, 0, 255)); };
          table[Lut::index_yuv(byte(c.y + y), byte(c.u + u), byte(c.v + v))] = label;
        }
      }
    }
  }
  return std::make_shared<const Lut>(std::move(table));
}

constexpr Rgb kOrange{240, 120, 20}, kBlue{20, 60, 220};

std::vector<Label> labels_of(const Lut& lut, PixelFormat format, int width, int height,
                             const std::vector<std::uint8_t>& bytes) {
  const Image image({bytes.data(), width, height, width * bytes_per_pixel(format), format}, nullptr, nullptr,
                    nullptr);
  LabelImage labels;
  Threshold().process({}, lut, Mask(), image, labels);
  EXPECT_EQ(labels.cell_px, is_bayer(format) ? 2 : 1);
  return labels.labels;
}

TEST(Threshold, ReadsEveryPixelFormat) {
  const auto lut = lut_with({{kOrange, label::kOrange}, {kBlue, label::kBlue}});
  const Yuv o = to_yuv(kOrange), b = to_yuv(kBlue);
  const auto expected = ElementsAre(label::kOrange, label::kOrange, label::kBlue, label::kBlue);
  EXPECT_THAT(labels_of(*lut, PixelFormat::kUyvy, 4, 1, {o.u, o.y, o.v, o.y, b.u, b.y, b.v, b.y}), expected);
  EXPECT_THAT(labels_of(*lut, PixelFormat::kYuyv, 4, 1, {o.y, o.u, o.y, o.v, b.y, b.u, b.y, b.v}), expected);
  const std::vector<std::uint8_t> rgb{kOrange.r, kOrange.g, kOrange.b, kOrange.r, kOrange.g, kOrange.b,
                                      kBlue.r,   kBlue.g,   kBlue.b,   kBlue.r,   kBlue.g,   kBlue.b};
  EXPECT_THAT(labels_of(*lut, PixelFormat::kRgb24, 4, 1, rgb), expected);
  std::vector<std::uint8_t> bgr = rgb;
  for (std::size_t i = 0; i < bgr.size(); i += 3) std::swap(bgr[i], bgr[i + 2]);
  EXPECT_THAT(labels_of(*lut, PixelFormat::kBgr24, 4, 1, bgr), expected);
}

TEST(Threshold, ReadsBayerQuadsInAllFourOrders) {
  const auto lut = lut_with({{kOrange, label::kOrange}, {kBlue, label::kBlue}});
  const auto mosaic = [](const char* upper, const char* lower) {
    std::vector<std::uint8_t> bytes;
    for (const char* row : {upper, lower}) {
      for (const Rgb color : {kOrange, kBlue}) {
        for (int i = 0; i < 2; ++i)
          bytes.push_back(row[i] == 'R' ? color.r : row[i] == 'G' ? color.g : color.b);
      }
    }
    return bytes;
  };
  const auto expected = ElementsAre(label::kOrange, label::kBlue);
  EXPECT_THAT(labels_of(*lut, PixelFormat::kBayerRg8, 4, 2, mosaic("RG", "GB")), expected);
  EXPECT_THAT(labels_of(*lut, PixelFormat::kBayerGr8, 4, 2, mosaic("GR", "BG")), expected);
  EXPECT_THAT(labels_of(*lut, PixelFormat::kBayerGb8, 4, 2, mosaic("GB", "RG")), expected);
  EXPECT_THAT(labels_of(*lut, PixelFormat::kBayerBg8, 4, 2, mosaic("BG", "GR")), expected);
}

TEST(Threshold, MonoCountsAsGrey) {
  const auto lut = lut_with({{{200, 200, 200}, label::kWhite}});
  EXPECT_THAT(labels_of(*lut, PixelFormat::kMono8, 3, 1, {10, 200, 90}),
              ElementsAre(label::kClear, label::kWhite, label::kClear));
}

TEST(Threshold, SkipsThePaddingOfRows) {
  const auto lut = lut_with({{{200, 200, 200}, label::kWhite}});
  const std::vector<std::uint8_t> bytes{200, 0,   200, 200,
                                        0,   200, 200, 200};  // two pixels and two bytes of padding a row
  const Image image({bytes.data(), 2, 2, 4, PixelFormat::kMono8}, nullptr, nullptr, nullptr);
  LabelImage labels;
  Threshold().process({}, *lut, Mask(), image, labels);
  EXPECT_THAT(labels.labels, ElementsAre(label::kWhite, label::kClear, label::kClear, label::kWhite));
}

}  // namespace
}  // namespace sslv::segmentation_test
