// SPDX-License-Identifier: Apache-2.0
#include "colors/table_in_light.h"

#include "support/drawn_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>

#include <gtest/gtest.h>

namespace sslv::table_in_light_test {
namespace {

constexpr std::array kColors{label::kOrange, label::kYellow, label::kBlue, label::kPink, label::kGreen};

/// A table as painted by hand: each print's colour with only small margins in brightness and hue.
std::shared_ptr<const Lut> painted_table() {
  std::vector<Label> labels(Lut::kEntries, label::kClear);
  const auto paint = [&](Label label, double darkest, double brightest, int radius) {
    const Rgb color = paint_color(label);
    for (double light = darkest; light <= brightest; light += 0.01) {
      const auto byte = [&](double value) {
        return static_cast<std::uint8_t>(std::min(255.0, value * light) + 0.5);
      };
      const Yuv c = to_yuv({byte(color.r), byte(color.g), byte(color.b)});
      for (int y = -radius; y <= radius; ++y) {
        for (int u = -radius; u <= radius; ++u) {
          for (int v = -radius; v <= radius; ++v) {
            const auto at = [](int value, int more) {
              return static_cast<std::uint8_t>(std::clamp(value + more, 0, 255));
            };
            labels[Lut::index_yuv(at(c.y, y), at(c.u, u), at(c.v, v))] = label;
          }
        }
      }
    }
  };
  paint(label::kField, 0.8, 1.2, 6);
  paint(label::kWhite, 0.8, 1.2, 6);
  for (const Label label : kColors) paint(label, 0.8, 1.15, 8);
  return std::make_shared<const Lut>(std::move(labels));
}

Rgb in_light(Rgb color, const std::array<double, 3>& gain) {
  const auto byte = [](double value) { return static_cast<std::uint8_t>(std::min(255.0, value) + 0.5); };
  return {byte(color.r * gain[0]), byte(color.g * gain[1]), byte(color.b * gain[2])};
}

std::string name_of(Label label) {
  return std::string(label::kNames[label]);
}

TEST(TableInLight, TheSameLightIsTheSameTable) {
  const auto accepted = painted_table();
  EXPECT_EQ(table_in_light(*accepted, {}), accepted->color_table());
}

TEST(TableInLight, ThingsKeepTheirLabelsInEveryLight) {
  const auto accepted = painted_table();
  for (const std::array<double, 3> gain :
       {std::array{0.3, 0.3, 0.3}, std::array{0.6, 0.6, 0.6}, std::array{1.5, 1.5, 1.5},
        std::array{2.0, 2.0, 2.0}, std::array{1.2, 1.0, 0.8}, std::array{0.36, 0.4, 0.44}}) {
    const Lut adapted_lut(table_in_light(*accepted, {gain}));
    for (const Label label : kColors) {
      const Rgb color = in_light(paint_color(label), gain);
      EXPECT_EQ(name_of(adapted_lut.of_rgb(color.r, color.g, color.b)), name_of(label))
          << gain[0] << " " << gain[2];
    }
    for (const Label label : {label::kField, label::kWhite, label::kBlack}) {
      const Rgb color = in_light(paint_color(label), gain);
      const Label seen = adapted_lut.of_rgb(color.r, color.g, color.b);
      EXPECT_TRUE(seen == label || seen == label::kClear) << name_of(label) << " is " << name_of(seen);
    }
  }
  const Rgb dim = in_light(paint_color(label::kPink), {0.4, 0.4, 0.4});
  EXPECT_EQ(accepted->of_rgb(dim.r, dim.g, dim.b), label::kClear) << "or this test shows nothing";
}

TEST(TableInLight, AreasOfOtherLightCountToo) {
  const auto accepted = painted_table();
  const Lut adapted_lut(table_in_light(*accepted, {{0.8, 0.8, 0.8}, 0.6, 1.4}));
  for (const double area : {0.6, 0.8, 1.0, 1.2, 1.4}) {
    for (const Label label : kColors) {
      const Rgb color = in_light(paint_color(label), {0.8 * area, 0.8 * area, 0.8 * area});
      EXPECT_EQ(name_of(adapted_lut.of_rgb(color.r, color.g, color.b)), name_of(label)) << area;
    }
    const Rgb carpet = in_light(paint_color(label::kField), {0.8 * area, 0.8 * area, 0.8 * area});
    const Label seen = adapted_lut.of_rgb(carpet.r, carpet.g, carpet.b);
    EXPECT_TRUE(seen == label::kField || seen == label::kClear) << name_of(seen);
  }
}

TEST(TableInLight, BackgroundColoursStayBackgroundInAreasOfOtherLight) {
  // Carpet in average light and green in the darkest area have the same colour: the label in average light,
  // carpet, wins.
  std::vector<Label> labels(Lut::kEntries, label::kClear);
  const auto paint = [&](Rgb color, Label label) {
    const Yuv c = to_yuv(color);
    for (int y = -8; y <= 8; ++y)
      labels[Lut::index_yuv(static_cast<std::uint8_t>(c.y + y), c.u, c.v)] = label;
  };
  paint({60, 120, 60}, label::kField);
  paint({100, 200, 100}, label::kGreen);
  const Lut accepted(std::move(labels));
  EXPECT_EQ(Lut(table_in_light(accepted, {{1, 1, 1}, 0.6, 1})).of_rgb(60, 120, 60), label::kField);
}

}  // namespace
}  // namespace sslv::table_in_light_test
