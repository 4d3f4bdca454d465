// SPDX-License-Identifier: Apache-2.0
#include "vision/label_picture.h"

#include "vision/find_runs.h"

#include <cstdlib>
#include <random>

#include <gmock/gmock.h>

namespace sslv::label_picture_test {
namespace {

Rgb pixel(const ImageView& picture, int x, int y) {
  const std::uint8_t* bytes = picture.row(y) + 3 * x;
  return {bytes[0], bytes[1], bytes[2]};
}

TEST(LabelPicture, EveryCellHasTheColorOfItsLabel) {
  std::mt19937 random(1);
  std::vector<std::uint8_t> buffer;
  // The second image is smaller: nothing of the first may remain in the buffer.
  for (const auto& [width, height] : {std::pair{21, 10}, std::pair{16, 9}}) {
    LabelImage labels{width, height, 2, {}};
    for (int i = 0; i < width * height; ++i)
      labels.labels.push_back(static_cast<Label>(random() % label::kCount));
    RunList runs;
    FindRuns().process({}, labels, runs);

    const ImageView picture = draw_label_picture(runs, buffer);
    ASSERT_EQ(picture.width, width);
    ASSERT_EQ(picture.height, height);
    EXPECT_EQ(picture.format, PixelFormat::kRgb24);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        ASSERT_EQ(pixel(picture, x, y), label::kDisplayColors[labels.row(y)[x]]) << x << ", " << y;
      }
    }
  }
}

TEST(LabelPicture, WithoutRunsItIsClear) {
  std::vector<std::uint8_t> buffer(1000, 255);
  const ImageView picture = draw_label_picture({4, 2, 1, {}, {}, {}}, buffer);
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 4; ++x) EXPECT_EQ(pixel(picture, x, y), label::kDisplayColors[label::kClear]);
  }
}

TEST(LabelPicture, ShowsWhatWasCutBecauseItFloods) {
  LabelImage labels{128, 64, 1, std::vector<Label>(128 * 64)};
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; x += 2) labels.row(y)[x] = label::kPink;
  }
  RunList runs;
  FindRuns().process({}, labels, runs);
  std::vector<std::uint8_t> buffer;
  const ImageView picture = draw_label_picture(runs, buffer);
  EXPECT_EQ(pixel(picture, 62, 62), label::kDisplayColors[label::kPink]);
  EXPECT_EQ(pixel(picture, 62, 63), label::kDisplayColors[label::kClear]);
  EXPECT_EQ(pixel(picture, 64, 0), label::kDisplayColors[label::kClear]);
}

TEST(LabelPicture, OwnLabelsHaveTheirColours) {
  std::vector<std::uint8_t> buffer;
  const RunList runs{2, 1, 1, {{0, 0, 1, 12}, {0, 1, 2, 13}}, {}, {}};
  const ImageView picture = draw_label_picture(runs, buffer, LabelSet({{12, "purple", "#8020c0"}}, ""));
  EXPECT_EQ(pixel(picture, 0, 0), (Rgb{0x80, 0x20, 0xc0}));
  EXPECT_EQ(pixel(picture, 1, 0), LabelSet::built_in().color(13)) << "without a name";
}

TEST(LabelPicture, DisplayColorsCanBeToldApart) {
  for (std::size_t a = 0; a < label::kCount; ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      const Rgb c = label::kDisplayColors[a], d = label::kDisplayColors[b];
      EXPECT_GT(std::abs(c.r - d.r) + std::abs(c.g - d.g) + std::abs(c.b - d.b), 90)
          << label::kNames[a] << ", " << label::kNames[b];
    }
  }
}

}  // namespace
}  // namespace sslv::label_picture_test
