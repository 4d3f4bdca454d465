// SPDX-License-Identifier: Apache-2.0
#include "vision/lut_from_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace sslv::lut_from_samples_test {
namespace {

using Color = std::array<double, 3>;

struct Paint {
  Label label;
  Color color;  // in light of strength 1
};
const std::vector<Paint> kPrints{{label::kOrange, {235, 105, 30}},
                                 {label::kYellow, {225, 195, 40}},
                                 {label::kBlue, {28, 80, 190}},
                                 {label::kPink, {228, 66, 155}},
                                 {label::kGreen, {95, 212, 75}}};
constexpr Color kField{30, 92, 60}, kWhite{205, 206, 200}, kBlack{24, 24, 27};

/// A pixel of a surface of this colour.
Rgb seen(const Color& color, double light, const Color& cast = {1, 1, 1}) {
  std::array<std::uint8_t, 3> out{};
  for (std::size_t c = 0; c < 3; ++c) {
    out[c] = static_cast<std::uint8_t>(std::clamp(std::lround(color[c] * light * cast[c]), 0L, 255L));
  }
  return {out[0], out[1], out[2]};
}

Color mixed(const Color& a, const Color& b, double share_of_b) {
  Color out{};
  for (std::size_t c = 0; c < 3; ++c) out[c] = a[c] + share_of_b * (b[c] - a[c]);
  return out;
}

/// An admin's clicks: `count` of each label, in light evenly spread from low to high, each with noise.
struct Clicks {
  double low = 1, high = 1;
  int count = 8;
  double noise = 0;
  Color cast{1, 1, 1};

  std::vector<ColorSample> samples() const {
    std::mt19937 random(1);
    std::normal_distribution<double> normal(0, 1);
    std::vector<Paint> paints = kPrints;
    paints.insert(paints.end(), {{label::kField, kField}, {label::kWhite, kWhite}, {label::kBlack, kBlack}});
    std::vector<ColorSample> out;
    for (const Paint& paint : paints) {
      for (int i = 0; i < count; ++i) {
        const double light = count == 1 ? low : low + (high - low) * i / (count - 1);
        Color color{};
        for (std::size_t c = 0; c < 3; ++c) {
          color[c] = std::min(255.0, paint.color[c] * light * cast[c]) + noise * normal(random);
        }
        out.push_back({paint.label, seen(color, 1)});
      }
    }
    return out;
  }
};

Label of(const Lut& lut, Rgb color) {
  return lut.of_rgb(color.r, color.g, color.b);
}

void expect_prints(const Lut& lut, double light, const Color& cast = {1, 1, 1}) {
  for (const Paint& print : kPrints) {
    EXPECT_EQ(label::kNames[of(lut, seen(print.color, light, cast))], label::kNames[print.label])
        << "in light " << light;
  }
}

void expect_background_clear(const Lut& lut, double light, const Color& cast = {1, 1, 1}) {
  const std::vector<std::pair<std::string, Color>> surfaces{
      {"field", kField},
      {"white", kWhite},
      {"black", kBlack},
      {"field and some white", mixed(kField, kWhite, 0.3)},
      {"field and more white", mixed(kField, kWhite, 0.6)},
      {"field and black", mixed(kField, kBlack, 0.5)},
      {"white and black", mixed(kWhite, kBlack, 0.5)}};
  for (const auto& [name, color] : surfaces) {
    EXPECT_EQ(label::kNames[of(lut, seen(color, light, cast))], "clear") << name << " in light " << light;
  }
}

TEST(LutFromSamples, ThreeSamplesDoInEvenLight) {
  for (const double light : {0.3, 0.6, 1.0, 1.6, 2.0}) {
    const Lut lut = lut_from_samples(Clicks{light, light, 3}.samples());
    expect_prints(lut, light);
    expect_background_clear(lut, light);
  }
}

TEST(LutFromSamples, HoldsFromTheBrightSideToTheDarkOne) {
  const Lut lut = lut_from_samples(Clicks{0.1, 1}.samples());
  for (double light = 0.15; light <= 1.01; light += 0.05) {
    expect_prints(lut, light);
    expect_background_clear(lut, light);
  }
}

TEST(LutFromSamples, HoldsBeyondSaturation) {
  const Lut lut = lut_from_samples(Clicks{0.5, 2}.samples());
  for (double light = 0.5; light <= 2.01; light += 0.1) {
    expect_prints(lut, light);
    expect_background_clear(lut, light);
  }
}

TEST(LutFromSamples, HoldsUnderColoredLight) {
  for (const Color& cast : {Color{1.3, 1, 0.7}, Color{0.75, 1, 1.3}, Color{0.75, 1, 0.75}}) {
    const Lut lut = lut_from_samples(Clicks{0.5, 1, 8, 0, cast}.samples());
    for (const double light : {0.5, 0.75, 1.0}) {
      expect_prints(lut, light, cast);
      expect_background_clear(lut, light, cast);
    }
  }
}

TEST(LutFromSamples, HoldsWithNoisySamples) {
  const Lut lut = lut_from_samples(Clicks{0.5, 1, 8, 15}.samples());
  for (const double light : {0.5, 0.75, 1.0}) {
    expect_prints(lut, light);
    expect_background_clear(lut, light);
  }
}

TEST(LutFromSamples, ALabelSeenInOneLightHoldsWhereTheFieldWasSeen) {
  std::vector<ColorSample> samples = Clicks{0.2, 1}.samples();
  std::erase_if(samples, [](const ColorSample& sample) {
    return sample.label == label::kYellow && sample.color.r < 200;
  });
  expect_prints(lut_from_samples(samples), 0.2);
}

TEST(LutFromSamples, ADotsEdgeOnBlackBelongsToTheDot) {
  const Lut lut = lut_from_samples(Clicks{0.5, 1}.samples());
  for (const Paint& print : kPrints) {
    EXPECT_EQ(of(lut, seen(mixed(kBlack, print.color, 0.7), 1)), print.label);
    EXPECT_EQ(of(lut, seen(mixed(kBlack, print.color, 0.1), 1)), label::kClear);
  }
}

TEST(LutFromSamples, ColoursSampledAsClearStayClear) {
  const Rgb purple{120, 60, 190};
  std::vector<ColorSample> samples = Clicks{0.5, 1}.samples();
  EXPECT_EQ(of(lut_from_samples(samples), {40, 70, 180}), label::kBlue);
  samples.push_back({label::kClear, {40, 70, 180}});
  EXPECT_EQ(of(lut_from_samples(samples), {40, 70, 180}), label::kClear);
  EXPECT_EQ(of(lut_from_samples(samples), purple), label::kClear);  // no label's colour
}

TEST(LutFromSamples, TheBackgroundCanBeNamed) {
  const Lut lut = lut_from_samples(Clicks{0.5, 1}.samples(), BackgroundLabels::kNamed);
  EXPECT_EQ(of(lut, seen(kField, 0.7)), label::kField);
  EXPECT_EQ(of(lut, seen(kWhite, 0.7)), label::kWhite);
  EXPECT_EQ(of(lut, seen(kBlack, 0.7)), label::kBlack);
  EXPECT_EQ(of(lut, seen(mixed(kField, kWhite, 0.5), 0.7)), label::kClear);
  expect_prints(lut, 0.7);
}

TEST(LutFromSamples, LabelsWithoutSamplesAreNotInTheTable) {
  const Lut none = lut_from_samples({});
  EXPECT_TRUE(std::all_of(none.yuv().labels.begin(), none.yuv().labels.end(),
                          [](Label label) { return label == label::kClear; }));
  const std::vector<ColorSample> one{{label::kPink, {228, 66, 155}}};
  const Lut pink = lut_from_samples(one);
  EXPECT_EQ(of(pink, {228, 66, 155}), label::kPink);
  EXPECT_EQ(of(pink, {28, 80, 190}), label::kClear);
}

}  // namespace
}  // namespace sslv::lut_from_samples_test
