// SPDX-License-Identifier: Apache-2.0
// Labels of the GPU compared with the CPU's plain stage: every format, tables of 7 and 8 bits.
#include "gpu/gpu_threshold.h"

#include "gpu/gl.h"
#include "gpu_or_skip.h"
#include "random_images.h"
#include "support/segment_check.h"
#include "vision/threshold.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace sslv {
namespace {

/// Compares with the CPU; returns the first difference, empty if there is none.
class Comparison {
 public:
  explicit Comparison(GpuContext& context) : gpu_(context) {}

  std::string operator()(const Lut& lut, const Mask& mask, const Image& image) {
    cpu_.process({}, lut, mask, image, plain_);
    // Overwrites the labels, so that those of an earlier image cannot count.
    std::fill(labels_.labels.begin(), labels_.labels.end(), Label{77});
    if (!gpu_.process(lut, mask, image, labels_)) return "no labels: " + gpu_.problem();
    const auto size = [](const LabelImage& of) { return std::tuple(of.width, of.height, of.cell_px); };
    if (size(plain_) != size(labels_) || plain_.labels.size() != labels_.labels.size()) return "another size";
    const auto [here, there] =
        std::mismatch(plain_.labels.begin(), plain_.labels.end(), labels_.labels.begin());
    if (here == plain_.labels.end()) return {};
    const auto at = static_cast<int>(here - plain_.labels.begin());
    return std::to_string(at % plain_.width) + ", " + std::to_string(at / plain_.width) + ": CPU " +
           std::to_string(*here) + ", GPU " + std::to_string(*there);
  }

  GpuThreshold& gpu() { return gpu_; }
  const LabelImage& plain() const { return plain_; }

 private:
  Threshold cpu_;
  GpuThreshold gpu_;
  LabelImage plain_, labels_;
};

class GpuThresholdTest : public WithGpu {
 protected:
  void SetUp() override {
    WithGpu::SetUp();
    if (!IsSkipped()) compare_ = std::make_unique<Comparison>(context());
  }
  Comparison& compare() { return *compare_; }

  std::unique_ptr<Comparison> compare_;
};

class GpuThresholdIn : public GpuThresholdTest, public ::testing::WithParamInterface<PixelFormat> {
 protected:
  /// Widths and heights must be multiples of these (ImageView).
  int unit_x() const { return is_bayer(format_) || is_yuv422(format_) ? 2 : 1; }
  int unit_y() const { return is_bayer(format_) ? 2 : 1; }

  PixelFormat format_ = GetParam();
};

TEST_P(GpuThresholdIn, EveryWidth) {
  Random random(1);
  for (int x = 1; x <= 70; ++x) {
    for (int y = 1; y <= 3; ++y) {
      Drawn drawn(format_, x * unit_x(), y * unit_y());
      drawn.fill(random);
      ASSERT_EQ(compare()(random_lut(7), Mask(), drawn.image()), "") << x * unit_x() << " x " << y * unit_y();
    }
  }
}

TEST_P(GpuThresholdIn, EveryStride) {
  Random random(2);
  for (int more = 0; more <= 40; ++more) {
    for (const bool is_turned : {false, true}) {
      Drawn drawn(format_, 46 * unit_x(), 3 * unit_y(), more);
      drawn.fill(random);
      if (is_turned) drawn.turn_over();
      ASSERT_EQ(compare()(random_lut(7), Mask(), drawn.image()), "")
          << more << " bytes more, turned: " << is_turned;
    }
  }
}

TEST_P(GpuThresholdIn, EveryTableAndMask) {
  Random random(3);
  std::vector<const Lut*> luts;
  for (const auto& lut : test_luts()) luts.push_back(lut.get());
  for (const Lut& lut : random_luts()) luts.push_back(&lut);
  for (std::size_t i = 0; i < luts.size(); ++i) {
    Drawn drawn(format_, 161 * unit_x(), 67 * unit_y(), 3);
    drawn.fill(random);
    for (int masks = 0; masks < 4; ++masks) {
      const Mask mask = random_mask(random, drawn.view().width, drawn.view().height);
      ASSERT_EQ(compare()(*luts[i], mask, drawn.image()), "") << "table " << i;
    }
  }
}

/// Typical and extreme contents of images.
void fill_tile(Random& random, const Drawn& shape, std::uint8_t* first, std::size_t bytes_a_row, int rows) {
  constexpr std::array<std::uint8_t, 10> kEdges{0, 1, 2, 126, 127, 128, 129, 253, 254, 255};
  const int kind = random_int(random, 0, 4);
  const auto base = static_cast<std::uint8_t>(random());
  const Rgb color = random_int(random, 0, 1) == 0 ? kCarpet : kColors[random() % kColors.size()];
  const std::array<std::uint8_t, 3> rgb{color.r, color.g, color.b};
  for (int y = 0; y < rows; ++y) {
    std::uint8_t* row = first + y * shape.view().stride_bytes;
    for (std::size_t x = 0; x < bytes_a_row; ++x) {
      const auto noise = static_cast<int>(random() % 9) - 4;
      switch (kind) {
        case 0: row[x] = static_cast<std::uint8_t>(random() >> 8); break;
        case 1: row[x] = base; break;
        case 2: row[x] = kEdges[random() % kEdges.size()]; break;
        case 3: row[x] = static_cast<std::uint8_t>(base + noise); break;
        default: row[x] = static_cast<std::uint8_t>(std::clamp(rgb[x % 3] + noise, 0, 255)); break;
      }
    }
  }
}

// A cell's label does not depend on its neighbours, so a large image can hold thousands of small ones.
TEST_P(GpuThresholdIn, ElevenThousandTiles) {
  constexpr int kTileX = 8, kTileY = 4, kColumns = 60, kRows = 62, kImages = 3;  // 11,160 per format
  Random random(static_cast<unsigned>(format_) + 4);
  const std::array luts{&random_lut(7), &random_lut(8), test_luts()[2].get()};
  for (int i = 0; i < kImages; ++i) {
    const int width = kTileX * kColumns * unit_x(), height = kTileY * kRows * unit_y();
    Drawn drawn(format_, width, height, random_int(random, 0, 50));
    const auto tile_bytes = static_cast<std::size_t>(kTileX * unit_x() * bytes_per_pixel(format_));
    for (int row = 0; row < kRows; ++row) {
      for (int column = 0; column < kColumns; ++column) {
        std::uint8_t* first =
            drawn.row(row * kTileY * unit_y()) + static_cast<std::size_t>(column) * tile_bytes;
        fill_tile(random, drawn, first, tile_bytes, kTileY * unit_y());
      }
    }
    ASSERT_EQ(
        compare()(*luts[static_cast<std::size_t>(i)], random_mask(random, width, height), drawn.image()), "");
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, GpuThresholdIn, ::testing::ValuesIn(kAllFormats),
                         [](const auto& of) { return std::string(name_of(of.param)); });

/// All 2^24 colours: one pixel, pair or quad each.
Drawn every_color(PixelFormat format) {
  constexpr int kSide = 4096;
  const bool is_rgb = format == PixelFormat::kRgb24;
  Drawn drawn(format, is_rgb ? kSide : 2 * kSide, is_bayer(format) ? 2 * kSide : kSide);
  for (int y = 0; y < kSide; ++y) {
    std::uint8_t* upper = drawn.row(is_bayer(format) ? 2 * y : y);
    std::uint8_t* lower = is_bayer(format) ? drawn.row(2 * y + 1) : nullptr;
    for (int x = 0; x < kSide; ++x) {
      const auto a = static_cast<std::uint8_t>(y >> 4), b = static_cast<std::uint8_t>(x >> 4);
      const auto c = static_cast<std::uint8_t>((y & 15) << 4 | (x & 15));
      if (is_rgb) {
        upper[3 * x] = a, upper[3 * x + 1] = b, upper[3 * x + 2] = c;
      } else if (is_bayer(format)) {
        // The second green runs through all values in another order.
        upper[2 * x] = a, upper[2 * x + 1] = b, lower[2 * x] = static_cast<std::uint8_t>(b * 7 + a + c);
        lower[2 * x + 1] = c;
      } else {
        upper[4 * x] = a, upper[4 * x + 1] = b, upper[4 * x + 2] = c;
        upper[4 * x + 3] = static_cast<std::uint8_t>(255 - b);
      }
    }
  }
  return drawn;
}

TEST_F(GpuThresholdTest, EveryColor) {
  for (const PixelFormat format : {PixelFormat::kUyvy, PixelFormat::kRgb24, PixelFormat::kBayerRg8}) {
    const Drawn drawn = every_color(format);
    for (const int bits : {7, 8}) {
      ASSERT_EQ(compare()(random_lut(bits), Mask(), drawn.image()), "")
          << sslv::name_of(format) << ", " << bits << " bits";
    }
  }
}

TEST_F(GpuThresholdTest, TableFormatAndSizeMayChangeWithEveryImage) {
  Random random(6);
  for (int i = 0; i < 150; ++i) {
    const PixelFormat format = kAllFormats[random() % kAllFormats.size()];
    const int width = 2 * random_int(random, 1, 200), height = 2 * random_int(random, 1, 60);
    Drawn drawn(format, width, height, random_int(random, 0, 9));
    drawn.fill(random);
    ASSERT_EQ(compare()(random_luts()[random() % random_luts().size()], random_mask(random, width, height),
                        drawn.image()),
              "")
        << i;
  }
}

TEST_F(GpuThresholdTest, AnotherTableAtTheSamePlaceIsAnotherTable) {
  Random random(7);
  Drawn drawn(PixelFormat::kRgb24, 64, 8);
  drawn.fill(random);
  // Tables are created and freed in turn, as when following the light, so their addresses may be equal.
  for (int i = 0; i < 5; ++i) {
    const auto lut = std::make_unique<const Lut>(random_lut(random, 7));
    ASSERT_EQ(compare()(*lut, Mask(), drawn.image()), "");
  }
}

TEST_F(GpuThresholdTest, AnEmptyImageHasNoLabels) {
  const Image nothing(ImageView{nullptr, 0, 0, 0, PixelFormat::kUyvy}, nullptr, nullptr, nullptr);
  EXPECT_EQ(compare()(*test_luts()[0], Mask(), nothing), "");
}

TEST_F(GpuThresholdTest, TooLargeAnImageIsRefusedAndTheNextOneTaken) {
  // One row repeated: more than the 128 MiB that every GPU must support. The largest GPUs accept it.
  constexpr int kWidth = 16'384, kHeight = 8'200;
  const std::vector<std::uint8_t> row(kWidth, 200);
  const Image large(ImageView{row.data(), kWidth, kHeight, 0, PixelFormat::kMono8}, nullptr, nullptr,
                    nullptr);
  GLint64 limit = 0;
  {
    const GpuContext::Use use(context());
    glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &limit);
  }
  const bool fits = limit >= GLint64{kWidth} * kHeight;
  const auto& lut = *test_luts()[3];
  LabelImage labels;
  EXPECT_EQ(compare().gpu().process(lut, Mask(), large, labels), fits);
  if (fits) {
    const Label label = lut.of_yuv(200, 128, 128);
    EXPECT_TRUE(
        std::all_of(labels.labels.begin(), labels.labels.end(), [=](Label is) { return is == label; }));
  } else {
    EXPECT_EQ(compare().gpu().problem(), "the image is too large for this GPU");
    EXPECT_FALSE(context().is_lost());
  }
  Random random(8);
  Drawn drawn(PixelFormat::kMono8, 99, 5);
  drawn.fill(random);
  EXPECT_EQ(compare()(lut, Mask(), drawn.image()), "");
}

TEST_F(GpuThresholdTest, MeasuresEachStepOfTheSameLabels) {
  Random random(9);
  Drawn drawn(PixelFormat::kUyvy, 640, 480);
  drawn.fill(random);
  const Lut& lut = random_lut(7);
  ASSERT_EQ(compare()(lut, Mask(), drawn.image()), "");
  LabelImage labels;
  GpuThreshold::Steps steps{};
  ASSERT_TRUE(compare().gpu().process(lut, Mask(), drawn.image(), labels, &steps));
  EXPECT_EQ(labels.labels, compare().plain().labels);
  for (const auto step : {steps.upload, steps.shader, steps.read_back}) {
    EXPECT_GT(step.count(), 0);
    EXPECT_LT(step, std::chrono::minutes(1));
  }
}

}  // namespace
}  // namespace sslv
