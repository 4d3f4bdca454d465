// SPDX-License-Identifier: Apache-2.0
#include "colors/surfaces.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include <gmock/gmock.h>

namespace sslv::surfaces_test {
namespace {

using ::testing::Optional;

constexpr Rgb kCarpet{60, 130, 70}, kFloor{132, 106, 80}, kOrange{220, 110, 40}, kPink{230, 60, 160},
    kWhite{225, 225, 225};
constexpr double kDot_px = 10;

/// An image of a softly patterned carpet with floor to the right of it, in any light. The noise does not
/// depend on the light.
class Hall {
 public:
  static constexpr int kWidth = 320, kHeight = 240, kFloorFrom = 230;

  Hall() : colors_(std::size_t{kWidth} * kHeight) {
    paint([](int x, int y) -> std::optional<Color3> {
      const double pattern = 1 + 0.1 * std::sin(x / 19.0) * std::cos(y / 23.0);
      const Rgb color = x < kFloorFrom ? kCarpet : kFloor;
      return Color3(Color3(color.r, color.g, color.b) * pattern);
    });
  }
  static bool is_carpet(int x) { return x < kFloorFrom; }

  void add_box(int left, int top, int right, int bottom, Rgb color) {
    paint([=](int x, int y) -> std::optional<Color3> {
      if (x < left || x >= right || y < top || y >= bottom) return {};
      return Color3(color.r, color.g, color.b);
    });
  }
  void add_disc(double middle_x, double middle_y, double radius, Rgb color) {
    paint([=](int x, int y) -> std::optional<Color3> {
      if (std::hypot(x - middle_x, y - middle_y) > radius) return {};
      return Color3(color.r, color.g, color.b);
    });
  }
  std::vector<std::uint8_t> expose(double light = 1, double noise_sigma = 2) const {
    std::mt19937 random(7);
    std::normal_distribution<double> noise(0, noise_sigma);
    std::vector<std::uint8_t> bytes;
    for (const Color3& color : colors_) {
      for (Eigen::Index c = 0; c < 3; ++c)
        bytes.push_back(
            static_cast<std::uint8_t>(std::clamp(light * color[c] + noise(random) + 0.5, 0.0, 255.0)));
    }
    return bytes;
  }

 private:
  void paint(const std::function<std::optional<Color3>(int, int)>& color_at) {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        if (const auto color = color_at(x, y)) colors_[static_cast<std::size_t>(y * kWidth + x)] = *color;
      }
    }
  }
  std::vector<Color3> colors_;
};

SurfaceColors see(const Hall& hall, std::vector<PixelDisc> left_out = {}, bool is_calibrated = false,
                  double noise_sigma = 2) {
  const std::vector<std::uint8_t> bytes = hall.expose(1, noise_sigma);
  const ImageView image{bytes.data(), Hall::kWidth, Hall::kHeight, 3 * Hall::kWidth, PixelFormat::kRgb24};
  std::vector<SmallPictures> pictures{SmallPictures(image, nullptr)};
  SurfaceSearch search{{&image, 1}, pictures, nullptr, left_out, kDot_px, {}, {}};
  if (is_calibrated) search.on_carpet = [](std::size_t, const auto& pixel) { return pixel.x() < 60; };
  return find_surfaces(search);
}

/// A table with the label that `label_of` returns for each colour.
ColorTable table_of(const std::function<Label(Yuv)>& label_of) {
  ColorTable table;
  for (std::size_t cell = 0; cell < table.labels.size(); ++cell)
    table.labels[cell] = label_of(table.color_of(cell));
  return table;
}
/// Green from luma `min_y` to `max_y`, else clear.
Lut green_within(int min_y, int max_y) {
  return Lut(table_of([=](Yuv c) { return c.y >= min_y && c.y <= max_y ? label::kGreen : label::kClear; }));
}

/// Share of a surface's pixels with the label in some light, counted in an image, to compare with the
/// margins' prediction.
double share_with(Label label, const Lut& lut, const Hall& hall, SurfaceKind kind, double light) {
  const std::vector<std::uint8_t> bytes = hall.expose(light);
  double count = 0, all = 0;
  for (int y = 0; y < Hall::kHeight; ++y) {
    for (int x = 0; x < Hall::kWidth; ++x) {
      if (Hall::is_carpet(x) != (kind == SurfaceKind::kCarpet)) continue;
      const std::uint8_t* pixel = &bytes[static_cast<std::size_t>(3 * (y * Hall::kWidth + x))];
      count += lut.of_rgb(pixel[0], pixel[1], pixel[2]) == label ? 1 : 0;
      ++all;
    }
  }
  return count / all;
}
/// The first of the lights 1, step, step^2, ... in which more than kFloodShare of the surface has the label.
double first_light(Label label, const Lut& lut, const Hall& hall, SurfaceKind kind, double step) {
  double light = 1;
  while (share_with(label, lut, hall, kind, light) <= kFloodShare) light *= step;
  return light;
}

const LabelMargin& margin_of(const std::vector<LabelMargin>& margins, Label label, SurfaceKind kind) {
  return *std::find_if(margins.begin(), margins.end(), [&](const LabelMargin& margin) {
    return margin.label == label && margin.surface == kind;
  });
}

TEST(Surfaces, MarginsAreWhereMoreOrLessLightMakesThemTheLabels) {
  const Hall hall;
  const SurfaceColors surfaces = see(hall);
  // Carpet has luma 92 to 113 and floor 99 to 121, before noise.
  const Lut lut = green_within(150, 255), dark = green_within(0, 70);
  const auto bright_margins = table_margins(lut, surfaces), dark_margins = table_margins(dark, surfaces);
  for (const SurfaceKind kind : {SurfaceKind::kCarpet, SurfaceKind::kFloor}) {
    SCOPED_TRACE(name_of(kind));
    const LabelMargin& bright = margin_of(bright_margins, label::kGreen, kind);
    EXPECT_THAT(bright.brighter,
                Optional(testing::DoubleNear(first_light(label::kGreen, lut, hall, kind, 1.005), 0.03)));
    EXPECT_FALSE(bright.darker) << "less light never makes it brighter";
    const LabelMargin& low = margin_of(dark_margins, label::kGreen, kind);
    EXPECT_THAT(low.darker,
                Optional(testing::DoubleNear(first_light(label::kGreen, dark, hall, kind, 1 / 1.005), 0.03)));
  }
  EXPECT_EQ(table_margins(green_within(0, 255), surfaces).front().brighter, 1.0) << "it has the label now";
}

TEST(Surfaces, MarginsAreOfColoursOnly) {
  const SurfaceColors surfaces = see(Hall());
  const Lut lut(table_of([](Yuv c) {
    return c.y < 60 ? label::kBlack : c.y < 140 ? label::kField : c.y < 200 ? label::kPink : label::kWhite;
  }));
  const auto margins = table_margins(lut, surfaces);
  EXPECT_EQ(margins.size(), 2U) << "of pink, to carpet and floor";
  for (const LabelMargin& margin : margins) EXPECT_EQ(margin.label, label::kPink);
}

TEST(Surfaces, StayClearInTheLightOfTheRange) {
  const Hall hall;
  const SurfaceColors surfaces = see(hall);
  ColorTable table = table_of([](Yuv) { return label::kGreen; });
  const ColorTable before = table;
  const ClearRange range;
  const std::size_t changed = clear_surfaces(table, surfaces, range, [](Label, Yuv) { return false; });
  EXPECT_EQ(changed,
            static_cast<std::size_t>(std::count(table.labels.begin(), table.labels.end(), label::kClear)));
  EXPECT_LT(changed, before.labels.size() / 10) << "it takes more than the surfaces";
  const Lut lut(table);
  for (const SurfaceKind kind : {SurfaceKind::kCarpet, SurfaceKind::kFloor}) {
    for (const double light : {range.darkest, 0.7, 1.0, 1.3, range.brightest - 0.1})
      EXPECT_LT(share_with(label::kGreen, lut, hall, kind, light), kFloodShare)
          << name_of(kind) << " in light " << light;
    EXPECT_GT(share_with(label::kGreen, lut, hall, kind, 2.2), 0.5) << name_of(kind) << " beyond the range";
  }
}

TEST(Surfaces, ShiningCarpetLargeEnoughForAFloodKeepsTheMargin) {
  for (int side = 14; side <= 40; side += 2) {
    Hall hall;
    hall.add_box(100, 100, 100 + side, 100 + side, {87, 188, 102});  // carpet in 1.45 times the light
    const SurfaceColors surfaces = see(hall);
    ColorTable table = table_of([](Yuv) { return label::kGreen; });
    clear_surfaces(table, surfaces, {}, [](Label, Yuv) { return false; });
    const auto least = min_to_carpet(table_margins(Lut(table), surfaces));
    ASSERT_TRUE(least);
    EXPECT_GT(std::abs(least->change), kWantedMargin) << side << " px: " << least->change;
  }
}

TEST(Surfaces, OnlyTheCarpetClearsKeptColours) {
  Hall hall;
  hall.add_box(20, 20, 120, 100, kOrange);  // an advertising board
  const SurfaceColors surfaces = see(hall);
  const Yuv orange = to_yuv(kOrange), carpet = to_yuv(kCarpet), floor = to_yuv(kFloor);
  const auto cleared = [&](bool keep) {
    ColorTable table = table_of([](Yuv) { return label::kOrange; });
    clear_surfaces(table, surfaces, {}, [&](Label label, Yuv) { return keep && label == label::kOrange; });
    return table;
  };
  const ColorTable kept = cleared(true), all = cleared(false);
  EXPECT_EQ(kept.of(orange), label::kOrange);
  EXPECT_EQ(all.of(orange), label::kClear);
  EXPECT_EQ(kept.of(floor), label::kOrange);
  EXPECT_EQ(all.of(floor), label::kClear);
  EXPECT_EQ(kept.of(carpet), label::kClear);
}

TEST(Surfaces, TheCarpetClearsNoKeptColourOfAnotherHue) {
  const Hall hall;
  const SurfaceColors surfaces = see(hall);
  const auto cleared = [&](bool keep) {
    ColorTable table = table_of([](Yuv) { return label::kBlue; });
    const auto is_bluer = [](Label, Yuv c) { return c.u - 128 > -0.13 * c.y; };  // the carpet: -0.17
    clear_surfaces(table, surfaces, {}, [&](Label label, Yuv c) { return keep && is_bluer(label, c); });
    return Lut(table);
  };
  const Lut kept = cleared(true), all = cleared(false);
  // Shaded carpet, and an equally dark colour that is bluer than noise explains.
  const Yuv carpet = to_yuv({33, 72, 39});
  const Yuv bluer{carpet.y, static_cast<std::uint8_t>(carpet.u + 8), carpet.v};
  EXPECT_EQ(all.of_yuv(bluer.y, bluer.u, bluer.v), label::kClear);
  EXPECT_EQ(kept.of_yuv(bluer.y, bluer.u, bluer.v), label::kBlue);
  EXPECT_EQ(kept.of_yuv(carpet.y, carpet.u, carpet.v), label::kClear);
  for (const double light : {0.5, 0.7, 1.0, 1.3, 1.5})
    EXPECT_LT(share_with(label::kBlue, kept, hall, SurfaceKind::kCarpet, light), kFloodShare) << light;
}

TEST(Surfaces, LeaveFieldWhiteAndBlackAlone) {
  const SurfaceColors surfaces = see(Hall());
  for (const Label label : {label::kField, label::kWhite, label::kBlack}) {
    ColorTable table = table_of([=](Yuv) { return label; });
    EXPECT_EQ(clear_surfaces(table, surfaces, {}, [](Label, Yuv) { return false; }), 0U);
    EXPECT_TRUE(is_surface_label(label));
  }
  EXPECT_FALSE(is_surface_label(label::kGreen));
}

TEST(Surfaces, ExcludeDotsAndLines) {
  Hall hall;
  hall.add_box(0, 120, Hall::kWidth, 126, kWhite);
  for (int i = 0; i < 12; ++i) hall.add_disc(15 + 23 * i, 30 + 5 * (i * 7 % 11), kDot_px / 2, kPink);
  const SurfaceColors surfaces = see(hall);
  constexpr ClearRange kAsSeen{.darkest = 1, .brightest = 1};
  for (const SurfaceKind kind : {SurfaceKind::kCarpet, SurfaceKind::kFloor, SurfaceKind::kOther})
    EXPECT_FALSE(reach_of(surfaces, kind, kAsSeen)(to_yuv(kPink))) << name_of(kind);
  for (const SurfaceKind kind : {SurfaceKind::kCarpet, SurfaceKind::kFloor})
    EXPECT_FALSE(reach_of(surfaces, kind, kAsSeen)(to_yuv(kWhite))) << name_of(kind);
  EXPECT_TRUE(reach_of(surfaces, SurfaceKind::kCarpet, kAsSeen)(to_yuv(kCarpet)));
  EXPECT_TRUE(reach_of(surfaces, SurfaceKind::kFloor, kAsSeen)(to_yuv(kFloor)));
}

TEST(Surfaces, LinesAreNotFloorOfSimilarColour) {
  constexpr Rgb kGrey{120, 120, 120};
  Hall hall;
  hall.add_box(Hall::kFloorFrom, 0, Hall::kWidth, Hall::kHeight, kGrey);
  hall.add_box(20, 120, Hall::kFloorFrom - 20, 126, kWhite);
  const SurfaceColors surfaces = see(hall);
  constexpr ClearRange kAsSeen{.darkest = 1, .brightest = 1};
  EXPECT_TRUE(reach_of(surfaces, SurfaceKind::kFloor, kAsSeen)(to_yuv(kGrey)));
  EXPECT_FALSE(reach_of(surfaces, SurfaceKind::kFloor, kAsSeen)(to_yuv(kWhite)));
  EXPECT_TRUE(reach_of(surfaces, SurfaceKind::kOther, kAsSeen)(to_yuv(kWhite)));
}

TEST(Surfaces, ExcludeTheGivenDiscs) {
  Hall hall;
  hall.add_disc(100, 100, 30, kPink);  // a large hull
  constexpr ClearRange kAsSeen{.darkest = 1, .brightest = 1};
  EXPECT_TRUE(reach_of(see(hall), SurfaceKind::kOther, kAsSeen)(to_yuv(kPink)));
  EXPECT_FALSE(reach_of(see(hall, {{0, 100, 100, 32}}), SurfaceKind::kOther, kAsSeen)(to_yuv(kPink)));
}

TEST(Surfaces, TheCarpetIsWhatIsCommonestOnTheField) {
  Hall hall;
  hall.add_box(60, 0, Hall::kFloorFrom, Hall::kHeight, kFloor);  // three quarters of the frame
  constexpr ClearRange kAsSeen{.darkest = 1, .brightest = 1};
  EXPECT_TRUE(reach_of(see(hall), SurfaceKind::kCarpet, kAsSeen)(to_yuv(kFloor)));
  const SurfaceColors surfaces = see(hall, {}, true);
  EXPECT_TRUE(reach_of(surfaces, SurfaceKind::kCarpet, kAsSeen)(to_yuv(kCarpet)));
  EXPECT_TRUE(reach_of(surfaces, SurfaceKind::kFloor, kAsSeen)(to_yuv(kFloor)));
}

// With noise estimated in whole levels, one camera's margin was 3 % in one image and 52 % in the next.
TEST(Surfaces, KnowTheirNoiseBetweenLevels) {
  for (const double sigma : {1.5, 1.8, 2.1, 2.4, 2.7, 3.0}) {
    SCOPED_TRACE(sigma);
    const SurfaceColors surfaces = see({}, {}, false, sigma);
    // Noise of Y, U and V from independent noise of red, green and blue (BT.601).
    EXPECT_NEAR(surfaces.noise_sigma[0], 0.67 * sigma, 0.25);
    EXPECT_NEAR(surfaces.noise_sigma[1], 0.62 * sigma, 0.25);
    EXPECT_NEAR(surfaces.noise_sigma[2], 0.66 * sigma, 0.25);
  }
}

TEST(Surfaces, TheLeastMarginIsTheNearestToTheCarpetEitherWay) {
  EXPECT_FALSE(min_to_carpet({}));
  std::vector<LabelMargin> margins{{label::kPink, SurfaceKind::kCarpet, {}, {}}};
  EXPECT_FALSE(min_to_carpet(margins));
  margins.push_back({label::kPink, SurfaceKind::kFloor, 1.08, 0.95});
  EXPECT_FALSE(min_to_carpet(margins)) << "no robot stands on the floor";
  margins.push_back({label::kGreen, SurfaceKind::kCarpet, 1.4, 0.7});
  margins.push_back({label::kBlue, SurfaceKind::kCarpet, 1.31, {}});
  const auto least = min_to_carpet(margins);
  ASSERT_TRUE(least);
  EXPECT_EQ(least->label, label::kGreen);
  EXPECT_NEAR(least->change, -0.3, 1e-9);
}

TEST(Surfaces, MarginsAreTheSameWithinNoise) {
  const std::vector<LabelMargin> seen{{label::kGreen, SurfaceKind::kCarpet, 1.20, {}}};
  const auto same_as = [&](LabelMargin other) { return about_same(seen, std::vector{other}); };
  EXPECT_TRUE(same_as({label::kGreen, SurfaceKind::kCarpet, 1.18, 1 / 2.45}));
  EXPECT_FALSE(same_as({label::kGreen, SurfaceKind::kCarpet, 1.10, {}}));
  EXPECT_FALSE(same_as({label::kGreen, SurfaceKind::kCarpet, {}, {}}));
  EXPECT_FALSE(same_as({label::kGreen, SurfaceKind::kCarpet, 1.20, 0.9}));
  EXPECT_FALSE(same_as({label::kGreen, SurfaceKind::kFloor, 1.20, {}}));
  EXPECT_FALSE(same_as({label::kPink, SurfaceKind::kCarpet, 1.20, {}}));
  EXPECT_FALSE(about_same(seen, {}));
}

TEST(Surfaces, MarginsInWords) {
  EXPECT_EQ(margin_text("carpet", "green", 0.092), "carpet becomes green at +9 %");
  EXPECT_EQ(margin_text("floor", "orange", -0.3), "floor becomes orange at \u221230 %");
  EXPECT_EQ(margin_text("carpet", "green", 0), "carpet is green now");
}

}  // namespace
}  // namespace sslv::surfaces_test
