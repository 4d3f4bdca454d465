// SPDX-License-Identifier: Apache-2.0
#include "vision/rectangle_fit.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace sslv::rectangle_fit_test {
namespace {

constexpr double kPixelMm = 6, kReachMm = 36, kGround = 40, kInk = 150;

/// The covered share of a square pixel, by sampling many points.
template <class IsIn>
double share_of(double x, double y, const IsIn& is_in) {
  constexpr int kPoints = 12;
  int in = 0;
  for (int i = 0; i < kPoints; ++i) {
    for (int j = 0; j < kPoints; ++j)
      in += is_in(x + ((i + 0.5) / kPoints - 0.5) * kPixelMm, y + ((j + 0.5) / kPoints - 0.5) * kPixelMm);
  }
  return static_cast<double>(in) / (kPoints * kPoints);
}

/// A shape as a camera without blur sees it, with noise.
template <class IsIn>
std::unique_ptr<RectangleSamples> picture_of(const IsIn& is_in, double noise) {
  auto out = std::make_unique<RectangleSamples>();
  std::mt19937 random(1);
  std::normal_distribution<double> off(0, noise);
  out->planes = 1;
  // Only a pixel's own blur: a uniform square.
  out->blur_mm2 = {{{kPixelMm * kPixelMm / 12, 0}, {0, kPixelMm * kPixelMm / 12}}};
  for (double y = -kReachMm; y <= kReachMm; y += kPixelMm) {
    for (double x = -kReachMm; x <= kReachMm; x += kPixelMm) {
      out->x[out->count] = static_cast<float>(x);
      out->y[out->count] = static_cast<float>(y);
      out->value[0][out->count++] =
          static_cast<float>(kGround + (kInk - kGround) * share_of(x, y, is_in) + off(random));
    }
  }
  return out;
}

/// Expects equal rectangles, up to a quarter turn, which swaps length and width.
void expect_near(const Rectangle& found, const Rectangle& true_one, double within_mm, double within_rad) {
  EXPECT_NEAR(found.x, true_one.x, within_mm);
  EXPECT_NEAR(found.y, true_one.y, within_mm);
  const double turned = std::remainder(found.angle_rad - true_one.angle_rad, std::numbers::pi / 2);
  EXPECT_NEAR(turned, 0, within_rad);
  EXPECT_NEAR(std::max(found.half_length, found.half_width),
              std::max(true_one.half_length, true_one.half_width), within_mm);
  EXPECT_NEAR(std::min(found.half_length, found.half_width),
              std::min(true_one.half_length, true_one.half_width), within_mm);
}

TEST(RectangleFit, FindsAPieceOfTape) {
  for (const double angle : {0.0, 0.3, 0.7, 1.2}) {
    for (const double half_width : {15.0, 19.0}) {
      const Rectangle tape{2, -3, 19, half_width, angle};
      const double c = std::cos(angle), s = std::sin(angle);
      const auto samples = picture_of(
          [&](double x, double y) {
            const double dx = x - tape.x, dy = y - tape.y;
            return std::abs(c * dx + s * dy) < tape.half_length &&
                   std::abs(c * dy - s * dx) < tape.half_width;
          },
          2);
      RectangleSamples* const groups[]{samples.get()};
      SCOPED_TRACE(testing::Message() << angle << " rad, " << half_width << " mm");
      expect_near(fit_rectangle({0, 0, 19, 19, 0}, groups), tape, 0.6, 0.06);
      // The rest is noise, and the pixels' blur, which is not a normal distribution.
      EXPECT_LT(samples->left2[0] / static_cast<double>(samples->count), 25);
    }
  }
}

TEST(RectangleFit, LeavesMoreOfADisc) {
  const auto samples = picture_of([](double x, double y) { return std::hypot(x - 1, y - 2) < 21.5; }, 2);
  RectangleSamples* const groups[]{samples.get()};
  fit_rectangle({0, 0, 19, 19, 0}, groups);
  EXPECT_GT(samples->left2[0] / static_cast<double>(samples->count), 60);
}

TEST(RectangleFit, OfNothingEnds) {
  for (const double noise : {0.0, 5.0}) {
    const auto samples = picture_of([](double, double) { return false; }, noise);
    RectangleSamples* const groups[]{samples.get()};
    const Rectangle found = fit_rectangle({0, 0, 19, 19, 0}, groups);
    EXPECT_TRUE(std::isfinite(found.x + found.y + found.half_length + found.half_width + found.angle_rad));
    EXPECT_TRUE(std::isfinite(samples->left2[0]));
  }
  const auto none = std::make_unique<RectangleSamples>();
  none->planes = 1;
  RectangleSamples* const groups[]{none.get()};
  EXPECT_TRUE(std::isfinite(fit_rectangle({0, 0, 19, 19, 0}, groups).x));
}

}  // namespace
}  // namespace sslv::rectangle_fit_test
