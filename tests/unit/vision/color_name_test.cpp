// SPDX-License-Identifier: Apache-2.0
#include "vision/color_name.h"

#include "support/drawn_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include <gtest/gtest.h>

namespace sslv::color_name_test {
namespace {

using Color = std::array<double, 3>;

constexpr std::array kAll{label::kOrange, label::kYellow, label::kBlue, label::kPink, label::kGreen};
constexpr std::array kSides{label::kPink, label::kGreen};
constexpr std::array kTeams{label::kYellow, label::kBlue};
constexpr Color kTop{24, 24, 27};

class ColorNames : public ::testing::Test {
 protected:
  /// Names a print's colour in the given light, on a robot's black top.
  ColorName name(Rgb print, double light, std::span<const Label> allowed) {
    const Color color{print.r * light, print.g * light, print.b * light};
    return name_color({color[0] - kTop[0] * light, color[1] - kTop[1] * light, color[2] - kTop[2] * light},
                      color, drawn_.lut(), allowed);
  }
  DrawnScene drawn_;
};

TEST_F(ColorNames, APrintHasItsNameInAnyLight) {
  for (const double light : {1.0, 0.7, 0.5, 0.35}) {
    for (const Label label : kAll) {
      const ColorName found = name(paint_color(label), light, kAll);
      EXPECT_EQ(found.color, label) << "in light " << light;
      EXPECT_GT(found.margin, 0.2) << label::kNames[label] << " in light " << light;
    }
  }
}

TEST_F(ColorNames, ClippedChannelsMayHaveBeenBrighter) {
  const auto clipped = [&](Label label, double light, std::span<const Label> allowed) {
    const Rgb print = paint_color(label);
    const Color color{std::min(255.0, print.r * light), std::min(255.0, print.g * light),
                      std::min(255.0, print.b * light)};
    return name_color({color[0] - kTop[0] * light, color[1] - kTop[1] * light, color[2] - kTop[2] * light},
                      color, drawn_.lut(), allowed);
  };
  for (const double light : {1.3, 1.6, 2.0, 2.5}) {
    for (const auto allowed : {std::span<const Label>(kSides), std::span<const Label>(kTeams)}) {
      for (const Label label : allowed) {
        SCOPED_TRACE(testing::Message() << label::kNames[label] << " in light " << light);
        const ColorName found = clipped(label, light, allowed);
        EXPECT_EQ(found.color, label);
        EXPECT_GT(found.margin, 0.4);
        EXPECT_LT(found.off, 1.6);
      }
    }
  }
}

TEST_F(ColorNames, OnlyAllowedNamesAreGiven) {
  EXPECT_EQ(name(paint_color(label::kOrange), 1, kTeams).color, label::kYellow);
  EXPECT_EQ(name(paint_color(label::kCyan), 1, kTeams).color, label::kBlue);
  EXPECT_EQ(name(paint_color(label::kOrange), 1, std::array{label::kGreen}).color, label::kGreen);
}

TEST_F(ColorNames, TheMarginIsZeroHalfwayBetweenTwo) {
  const auto pink = drawn_.lut().chromaticity_mean(label::kPink),
             green = drawn_.lut().chromaticity_mean(label::kGreen);
  Color between;
  for (std::size_t c = 0; c < 3; ++c) between[c] = 100 * (pink[c] + green[c]);
  EXPECT_NEAR(name_color(between, between, drawn_.lut(), kSides).margin, 0, 0.01);
}

TEST_F(ColorNames, TheMarginFallsFromOneColourToTheOther) {
  const auto pink = drawn_.lut().chromaticity_mean(label::kPink),
             green = drawn_.lut().chromaticity_mean(label::kGreen);
  double last = 2;
  for (const double share : {0.0, 0.1, 0.2, 0.3, 0.4, 0.49}) {
    Color mixed;
    for (std::size_t c = 0; c < 3; ++c) mixed[c] = 200 * (pink[c] + share * (green[c] - pink[c]));
    // The table does not know this grey, so only shares count.
    const ColorName found = name_color(mixed, {128, 128, 128}, drawn_.lut(), kSides);
    EXPECT_EQ(found.color, label::kPink);
    EXPECT_LT(found.margin, last);
    last = found.margin;
  }
  EXPECT_GT(last, 0);
}

TEST_F(ColorNames, TheTableMayContradict) {
  const auto pink = drawn_.lut().chromaticity_mean(label::kPink);
  const Color seen{200 * pink[0], 200 * pink[1], 200 * pink[2]};
  const Rgb green = paint_color(label::kGreen);
  const Color table_says_green{1.0 * green.r, 1.0 * green.g, 1.0 * green.b};
  EXPECT_GT(name_color(seen, seen, drawn_.lut(), kSides).margin, 0);
  EXPECT_LT(name_color(seen, table_says_green, drawn_.lut(), kSides).margin, 0);
  const Rgb orange = paint_color(label::kOrange);
  EXPECT_GT(name_color(seen, {1.0 * orange.r, 1.0 * orange.g, 1.0 * orange.b}, drawn_.lut(), kSides).margin,
            0)
      << "a name that is not allowed does not count";
}

TEST_F(ColorNames, OtherColoursAreFurtherOffThanAnyPrint) {
  double furthest = 0;
  for (const double light : {1.0, 0.5, 0.35}) {
    for (const Label label : kSides)
      furthest = std::max(furthest, name(paint_color(label), light, kSides).off);
  }
  for (const std::uint8_t paint : {paint::kRed, paint::kPurple, paint::kBrown, paint::kSkin,
                                   std::uint8_t{label::kWhite}, std::uint8_t{label::kBlue}}) {
    for (const double light : {1.0, 0.5, 0.35})
      EXPECT_GT(name(paint_color(paint), light, kSides).off, 1.5 * furthest)
          << int{paint} << " in light " << light;
  }
}

TEST_F(ColorNames, SurvivesImpossibleColours) {
  for (const Color& odd : {Color{0, 0, 0}, Color{-50, -20, -90}, Color{1e30, 0, 0}, Color{-1e30, 400, 1e9}}) {
    const ColorName found = name_color(odd, odd, drawn_.lut(), kAll);
    EXPECT_LT(found.color, label::kCount);
  }
  const ColorName nothing = name_color({0, 0, 0}, {0, 0, 0}, Lut(), kSides);
  EXPECT_FALSE(std::isnan(nothing.margin)) << "a table without colours";
}

}  // namespace
}  // namespace sslv::color_name_test
