// SPDX-License-Identifier: Apache-2.0
#include "vision/disc_fit.h"

#include "capture/simulator/simulator_sensor.h"
#include "support/drawn_scene.h"
#include "support/simd_target.h"
#include "vision/disc_kernel.h"
#include "vision/sample_planes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

namespace sslv::disc_fit_test {
namespace {

/// The contrast divided by its standard deviation, for all planes together; a plane's variance counts as at
/// least 1.
double significance(const DiscFit& fit) {
  double sum = 0;
  for (const DiscFit::Plane& p : fit.planes)
    sum += p.contrast * p.contrast * p.spread / std::max(1.0, p.left / p.free);
  return std::sqrt(sum);
}

const std::array kAllFormats{PixelFormat::kUyvy,     PixelFormat::kYuyv,     PixelFormat::kRgb24,
                             PixelFormat::kBgr24,    PixelFormat::kBayerRg8, PixelFormat::kBayerGr8,
                             PixelFormat::kBayerGb8, PixelFormat::kBayerBg8};
constexpr double kMmPerPx = 5.6, kRadiusMm = 20, kMarginMm = 10, kBlurPx = 0.46;
constexpr std::array kInk{200.0, 84.0, 150.0}, kGround{44.0, 44.0, 47.0};

/// A camera that looks straight at a plane: x to the right, y down, the patch's origin at pixel (u, v).
PlanePatch flat_patch(double u, double v, double mm_per_px = kMmPerPx) {
  return {{u, v}, {0, 0}, mm_per_px, 0, 0, 0, 0, 0, mm_per_px, 0, 0, 0};
}

struct Disc {
  double u, v, radius_px;
};

/// An image of uniform discs on a uniform background, as if without vignetting, with independent noise
/// in each sample. The buffer has no slack after the last byte.
class DiscPicture {
 public:
  DiscPicture(PixelFormat format, int width, int height, const std::vector<Disc>& discs, double noise,
              unsigned stream = 1, int padding = 0, int bits = 8, double brightness = 1) {
    SimulatorOptions options = plain_options(format, 0);
    options.width = width, options.height = height, options.bits = bits;
    SimulatorSensor sensor(options, 0);
    LightPicture light(width, height);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        double share = 0;
        for (const Disc& disc : discs) share += share_of(disc, x, y);
        for (std::size_t c = 0; c < 3; ++c) {
          light.at(x, y)[c] = static_cast<std::uint16_t>(
              LightPicture::kPerGrey * brightness * (kGround[c] + share * (kInk[c] - kGround[c])) + 0.5);
        }
      }
    }
    std::vector<std::uint8_t> pixels(sensor.picture_bytes());
    sensor.develop(light, {0, 0, width, height}, pixels.data());
    std::mt19937 random(stream);
    std::normal_distribution<double> normal(0, 1);
    for (std::uint8_t& pixel : pixels)
      pixel = static_cast<std::uint8_t>(std::clamp(std::round(pixel + noise * normal(random)), 0.0, 255.0));
    const int row_bytes = width * bytes_per_pixel(format), stride = row_bytes + padding;
    const int rows = bits > 8 ? 2 * height : height;  // the low bits follow the high ones
    const int bytes = stride * (rows - 1) + row_bytes;
    bytes_ = std::make_unique<std::uint8_t[]>(static_cast<std::size_t>(bytes));
    std::fill_n(bytes_.get(), bytes, std::uint8_t{255});
    for (int y = 0; y < rows; ++y)
      std::copy_n(pixels.data() + std::ptrdiff_t{y} * row_bytes, row_bytes,
                  bytes_.get() + std::ptrdiff_t{y} * stride);
    view_ = {bytes_.get(), width, height, stride, format, bits > 8 ? std::ptrdiff_t{stride} * height : 0};
  }
  const ImageView& view() const { return view_; }

 private:
  static double share_of(const Disc& disc, int x, int y) {
    const double distance = std::hypot(x - disc.u, y - disc.v);
    if (distance > disc.radius_px + 1) return 0;
    if (distance < disc.radius_px - 1) return 1;
    constexpr int kPoints = 16;
    int inside = 0;
    for (int i = 0; i < kPoints * kPoints; ++i) {
      const double px = x + (i % kPoints + 0.5) / kPoints - 0.5, py = y + (i / kPoints + 0.5) / kPoints - 0.5;
      inside += std::hypot(px - disc.u, py - disc.v) < disc.radius_px ? 1 : 0;
    }
    return inside / static_cast<double>(kPoints * kPoints);
  }

  std::unique_ptr<std::uint8_t[]> bytes_;
  ImageView view_;
};

class DiscFitIn : public ::testing::TestWithParam<PixelFormat> {};

TEST_P(DiscFitIn, TheCentreIsAsGoodAsTheFitSays) {
  // 200 discs at different subpixel positions; the fits start up to 1 mm off.
  std::mt19937 random(1);
  std::uniform_real_distribution<double> within(-0.5, 0.5);
  constexpr double kNoise = 10;  // larger than the model's other errors
  DiscMeter meter;
  double chi2 = 0, far = 0;
  int discs = 0;
  for (unsigned picture = 0; picture < 8; ++picture) {
    std::vector<Disc> drawn;
    for (int i = 0; i < 25; ++i) {
      drawn.push_back({16 + 30.0 * (i % 5) + 2 * within(random), 16 + 30.0 * (i / 5) + 2 * within(random),
                       kRadiusMm / kMmPerPx});
    }
    const DiscPicture shown(GetParam(), 156, 156, drawn, kNoise, picture);
    for (const Disc& disc : drawn) {
      const double x_mm = 1.4 * within(random), y_mm = 1.4 * within(random);
      const PlanePatch patch = flat_patch(disc.u, disc.v);
      const DiscFit fit =
          fit_disc(meter.measure(shown.view(), patch, {x_mm, y_mm, kRadiusMm, kMarginMm}, {}, kBlurPx));
      ASSERT_TRUE(fit.ok);
      const auto [dx, dy] = fit.offset_mm();
      const double ex = x_mm + dx, ey = y_mm + dy;
      const double one = fit.n00 * ex * ex + 2 * fit.n01 * ex * ey + fit.n11 * ey * ey;
      chi2 += one;
      far = std::max(far, one);
      ++discs;
    }
  }
  ASSERT_EQ(discs, 200);
  EXPECT_GT(chi2 / discs, 1.4);
  EXPECT_LT(chi2 / discs, 2.6);
  EXPECT_LT(far, 25);
}

TEST_P(DiscFitIn, ItsPlanesAddUp) {
  const DiscPicture shown(GetParam(), 64, 64, {{32.2, 31.7, kRadiusMm / kMmPerPx}}, 4);
  DiscMeter meter;
  const DiscFit fit =
      fit_disc(meter.measure(shown.view(), flat_patch(32, 32), {0, 0, kRadiusMm, kMarginMm}, {}, kBlurPx));
  ASSERT_TRUE(fit.ok);
  double n00 = 0, g1 = 0;
  for (const DiscFit::Plane& plane : fit.planes) {
    const double variance = plane.left / plane.free;
    n00 += plane.n00 / variance;
    g1 += plane.g1 / variance;
  }
  EXPECT_NEAR(n00, fit.n00, 1e-6 * fit.n00);
  EXPECT_NEAR(g1, fit.g1, 1e-6 * std::abs(fit.g1) + 1e-9);
}

TEST_P(DiscFitIn, TellsTheColourAndThatThereIsADisc) {
  const DiscPicture shown(GetParam(), 40, 40, {{19.3, 20.6, kRadiusMm / kMmPerPx}}, 4);
  DiscMeter meter;
  const DiscFit fit = fit_disc(
      meter.measure(shown.view(), flat_patch(19.3, 20.6), {0, 0, kRadiusMm, kMarginMm}, {}, kBlurPx));
  ASSERT_TRUE(fit.ok);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(fit.color[c], kInk[c], 8) << c;
    EXPECT_NEAR(fit.contrast[c], kInk[c] - kGround[c], 10) << c;
  }
  EXPECT_GT(fit.r2, 0.95);
  EXPECT_LE(fit.r2, 1);
  EXPECT_GT(significance(fit), 50);

  const DiscFit none =
      fit_disc(meter.measure(shown.view(), flat_patch(8, 32), {0, 0, kRadiusMm, kMarginMm}, {}, kBlurPx));
  EXPECT_LT(none.r2, 0.4) << "on the bare ground";
  EXPECT_LT(significance(none), 15);
}

/// In this weak light, a dot differs from its ground by a third of an 8-bit level.
TEST(DiscFitOfDeepPixels, SeesWhatEightBitsDoNotShow) {
  constexpr double kBrightness = 0.002;
  for (const PixelFormat format :
       {PixelFormat::kBayerRg8, PixelFormat::kBayerGr8, PixelFormat::kBayerGb8, PixelFormat::kBayerBg8}) {
    SCOPED_TRACE(std::string(name_of(format)));
    const DiscPicture shown(format, 40, 40, {{19.3, 20.6, kRadiusMm / kMmPerPx}}, 0, 1, 5, 16, kBrightness);
    for (const std::int64_t target : cpu_targets()) {
      const OnlyTarget only(target);
      SCOPED_TRACE(name_of_target(target));
      DiscMeter meter;
      const auto fit_of = [&](const ImageView& view) {
        return fit_disc(
            meter.measure(view, flat_patch(19.3, 20.6), {0, 0, kRadiusMm, kMarginMm}, {}, kBlurPx));
      };
      const DiscFit fit = fit_of(shown.view());
      ASSERT_TRUE(fit.ok);
      for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(fit.contrast[c], kBrightness * (kInk[c] - kGround[c]), 0.03) << c;
      EXPECT_GT(fit.r2, 0.95);
      ImageView cut = shown.view();
      cut.to_low_bits = 0;
      EXPECT_EQ(fit_of(cut).r2, 0);
    }
  }
}

TEST(DiscFitOfDeepPixels, ReadsNothingOutsideThePicture) {
  for (const std::int64_t target : cpu_targets()) {
    const OnlyTarget only(target);
    DiscMeter meter;
    const DiscPicture shown(PixelFormat::kBayerRg8, 6, 4, {}, 0, 1, 0, 12);
    for (const double u : {0.0, 5.0, 8.0}) {
      for (const double v : {0.0, 3.0, 6.0})
        meter.measure(shown.view(), flat_patch(u, v), {0, 0, 20, kMarginMm}, {}, kBlurPx);
    }
  }
}

TEST_P(DiscFitIn, AllInstructionSetsGiveTheSameSums) {
  // A slanted and curved patch, an outline that cuts the disc, and all three planes.
  const DiscPicture shown(GetParam(), 48, 48, {{22.4, 25.1, kRadiusMm / kMmPerPx}}, 4);
  PlanePatch patch = flat_patch(22, 25);
  patch.xv = 0.7, patch.yu = -0.9, patch.xuu = 0.004, patch.xvv = -0.003, patch.yuv = 0.005;
  DiscOutline outline{-20, 3, std::cos(0.4), std::sin(0.4), 55, 40};
  const auto measured = [&] {
    DiscMeter meter;
    return meter.measure(shown.view(), patch, {1.5, -0.8, kRadiusMm, kMarginMm}, outline, 0.55);
  };
  const DiscMeasure best = measured();
  ASSERT_TRUE(best.in_view);
  for (const std::int64_t target : cpu_targets()) {
    const OnlyTarget only(target);
    const DiscMeasure other = measured();
    for (std::size_t p = 0; p < 3; ++p) {
      const auto &a = best.planes[p], &b = other.planes[p];
      ASSERT_GT(a.n, 5);
      const auto all = [](const auto& sums) {
        return std::array{sums.n,  sums.xx, sums.yy, sums.xy, sums.xt, sums.yt, sums.x, sums.y,
                          sums.tt, sums.t,  sums.xv, sums.yv, sums.tv, sums.v,  sums.vv};
      };
      EXPECT_EQ(all(a), all(b)) << name_of_target(target) << " plane " << p;
    }
  }
}

TEST_P(DiscFitIn, AllInstructionSetsGiveTheSameSumsOfABall) {
  const DiscPicture shown(GetParam(), 48, 48, {{22.4, 25.1, kRadiusMm / kMmPerPx}}, 4);
  PlanePatch patch = flat_patch(22, 25);
  patch.xv = 0.7, patch.yu = -0.9, patch.xuu = 0.004, patch.xvv = -0.003, patch.yuv = 0.005;
  const auto summed = [&] {
    std::vector<BallSums> out;
    const auto samples = std::make_unique<PlaneSamples>();
    for (const auto& grids : sample_planes(GetParam()).groups) {
      if (grids.empty()) continue;
      const KernelPatch flat = kernel_patch(patch);
      samples->count = 0;
      for (const SampleGrid& grid : grids) read_samples(flat, 0, 0, 40, shown.view(), grid, *samples);
      std::fill_n(samples->keep.begin(), samples->count, 1.0F);
      out.push_back(
          sum_ball({flat, 1.5F, -0.8F, 20, 35, 1, 0.1F, 0.9F, 0.55F, grids.front().wide_px}, *samples));
    }
    return out;
  };
  const auto best = summed();
  ASSERT_FALSE(best.empty());
  ASSERT_GT(best.front().products[BallColumn::kGround][BallColumn::kGround], 5);
  for (const std::int64_t target : cpu_targets()) {
    const OnlyTarget only(target);
    const auto other = summed();
    for (std::size_t g = 0; g < best.size(); ++g) {
      EXPECT_EQ(other[g].products, best[g].products) << name_of_target(target) << " group " << g;
      for (std::size_t p = 0; p < 3; ++p) {
        EXPECT_EQ(other[g].planes[p].with, best[g].planes[p].with) << name_of_target(target);
        EXPECT_EQ(other[g].planes[p].square, best[g].planes[p].square) << name_of_target(target);
      }
    }
  }
}

// The last vector is padded after the last sample. Whatever the plane's curvature, the padding must not count
// as part of the disc.
TEST_P(DiscFitIn, PaddingIsNotASample) {
  const DiscPicture shown(GetParam(), 48, 48, {}, 4);
  PlanePatch patch = flat_patch(24, 24);
  patch.xuu = -patch.xu / 1e5, patch.yu = patch.yuu = 0;
  std::vector<double> counts;
  for (const std::int64_t target : cpu_targets()) {
    const OnlyTarget only(target);
    DiscMeter meter;
    counts.push_back(
        meter.measure(shown.view(), patch, {0.3, 0.2, kRadiusMm, kMarginMm}, {}, kBlurPx).planes[0].n);
  }
  EXPECT_THAT(counts, testing::Each(counts.front()));
}

TEST_P(DiscFitIn, ReadsNothingOutsideThePicture) {
  // In all corners and beyond all edges; the buffer has no slack, so that a sanitizer detects reads beyond
  // it.
  for (const std::int64_t target : cpu_targets()) {
    const OnlyTarget only(target);
    DiscMeter meter;
    for (const auto& [width, height] : {std::pair{64, 48}, std::pair{2, 2}, std::pair{6, 4}}) {
      const DiscPicture shown(GetParam(), width, height, {}, 0);
      for (const double u : {-3.0, 0.0, 1.0, width / 2.0, width - 1.0, width + 2.0}) {
        for (const double v : {-3.0, 0.0, 1.0, height / 2.0, height - 1.0, height + 2.0}) {
          for (const double radius_mm : {6.0, 20.0, 200.0})
            meter.measure(shown.view(), flat_patch(u, v), {0, 0, radius_mm, kMarginMm}, {}, kBlurPx);
        }
      }
    }
  }
}

TEST_P(DiscFitIn, ADiscInACornerIsWhereItIs) {
  for (const double u : {3.2, 60.4}) {
    for (const double v : {3.3, 44.1}) {
      const DiscPicture shown(GetParam(), 64, 48, {{u, v, kRadiusMm / kMmPerPx}}, 0);
      DiscMeter meter;
      const DiscFit fit = fit_disc(meter.measure(shown.view(), flat_patch(u + 0.1, v - 0.1),
                                                 {0, 0, kRadiusMm, kMarginMm}, {}, kBlurPx));
      ASSERT_TRUE(fit.ok);
      EXPECT_NEAR(fit.offset_mm()[0], -0.1 * kMmPerPx, 0.1 * kMmPerPx);
      EXPECT_NEAR(fit.offset_mm()[1], 0.1 * kMmPerPx, 0.1 * kMmPerPx);
    }
  }
}

TEST_P(DiscFitIn, AHugeDiscIsLookedAtInSomeOfItsRows) {
  for (const double radius_px : {60.0, 150.0, 240.0}) {
    const int side = static_cast<int>(2.3 * radius_px) / 2 * 2;
    const double u = side / 2 + 0.3, v = side / 2 - 0.4;
    const DiscPicture shown(GetParam(), side, side, {{u, v, radius_px}}, 4);
    DiscMeter meter;
    const double mm_per_px = 0.3;
    const DiscMeasure measure =
        meter.measure(shown.view(), flat_patch(u + 0.2, v + 0.2, mm_per_px),
                      {0, 0, radius_px * mm_per_px, 0.1 * radius_px * mm_per_px}, {}, kBlurPx);
    const DiscFit fit = fit_disc(measure);
    ASSERT_TRUE(fit.ok) << radius_px;
    for (const auto& plane : measure.planes) EXPECT_LE(plane.n, static_cast<double>(PlaneSamples::kMax));
    EXPECT_NEAR(fit.offset_mm()[0] / mm_per_px, -0.2, 0.1) << radius_px;
    EXPECT_NEAR(fit.offset_mm()[1] / mm_per_px, -0.2, 0.1) << radius_px;
  }
}

TEST_P(DiscFitIn, RowsMayBePadded) {
  const std::vector<Disc> discs{{21.6, 18.2, kRadiusMm / kMmPerPx}};
  const DiscPicture tight(GetParam(), 40, 40, discs, 4), padded(GetParam(), 40, 40, discs, 4, 1, 24);
  DiscMeter meter;
  const ExpectedDisc expected{0.5, 0.5, kRadiusMm, kMarginMm};
  const auto measured = [&](const DiscPicture& picture) {
    return fit_disc(meter.measure(picture.view(), flat_patch(21.6, 18.2), expected, {}, kBlurPx));
  };
  const DiscFit a = measured(tight), b = measured(padded);
  ASSERT_TRUE(a.ok);
  EXPECT_EQ(a.offset_mm(), b.offset_mm());
  EXPECT_EQ(a.color, b.color);
}

TEST_P(DiscFitIn, IgnoresPixelsBeyondTheOutline) {
  // White carpet beside the top must not change what is found on it.
  const DiscPicture plain(GetParam(), 60, 40, {{20, 20, kRadiusMm / kMmPerPx}}, 0);
  const DiscPicture beside(GetParam(), 60, 40, {{20, 20, kRadiusMm / kMmPerPx}, {32, 20, 5}}, 0);
  DiscMeter meter;
  const DiscOutline outline{-40, 0, 1, 0, 1000, 62};  // excludes everything more than 22 mm right of the disc
  const auto measured = [&](const DiscPicture& picture) {
    return fit_disc(
        meter.measure(picture.view(), flat_patch(20, 20), {0, 0, kRadiusMm, 25}, outline, kBlurPx));
  };
  const DiscFit a = measured(plain), b = measured(beside);
  ASSERT_TRUE(a.ok);
  EXPECT_NEAR(a.offset_mm()[0], b.offset_mm()[0], 0.02);
  EXPECT_NEAR(a.r2, b.r2, 0.01);
}

INSTANTIATE_TEST_SUITE_P(Formats, DiscFitIn, ::testing::ValuesIn(kAllFormats),
                         [](const auto& param) { return std::string(name_of(param.param)); });

TEST(DiscFit, APictureWithoutColoursSaysNothing) {
  const DiscPicture shown(PixelFormat::kMono8, 40, 40, {{20, 20, 3.5}}, 0);
  DiscMeter meter;
  const DiscMeasure measure = meter.measure(shown.view(), flat_patch(20, 20), {0, 0, 20, 10}, {}, kBlurPx);
  EXPECT_FALSE(measure.in_view);
  EXPECT_FALSE(fit_disc(measure).ok);
}

TEST(DiscFit, OutsideThePictureThereIsNoDisc) {
  const DiscPicture shown(PixelFormat::kUyvy, 40, 40, {}, 0);
  DiscMeter meter;
  for (const double u : {-100.0, 1000.0, 1e6}) {
    EXPECT_FALSE(fit_disc(meter.measure(shown.view(), flat_patch(u, 20), {0, 0, 20, 10}, {}, kBlurPx)).ok);
    EXPECT_FALSE(fit_disc(meter.measure(shown.view(), flat_patch(20, u), {0, 0, 20, 10}, {}, kBlurPx)).ok);
  }
}

TEST(DiscFit, AnEvenPictureHasNoDisc) {
  // Also without noise: no division by zero.
  for (const PixelFormat format : kAllFormats) {
    const DiscPicture shown(format, 40, 40, {}, 0);
    DiscMeter meter;
    const DiscFit fit =
        fit_disc(meter.measure(shown.view(), flat_patch(20, 20), {0, 0, 20, 10}, {}, kBlurPx));
    EXPECT_FALSE(std::isnan(fit.r2));
    EXPECT_LT(significance(fit), 1);
    EXPECT_LT(std::abs(fit.n00) + std::abs(fit.n11), 1e-3);
  }
}

TEST(DiscFit, TheGroundOfSeveralDiscsIsCommon) {
  std::vector<Disc> discs;
  for (int i = 0; i < 4; ++i) discs.push_back({20.0 + 30 * i, 20.3, kRadiusMm / kMmPerPx});
  const DiscPicture shown(PixelFormat::kRgb24, 130, 40, discs, 2);
  DiscMeter meter;
  std::vector<DiscMeasure> measures;
  for (const Disc& disc : discs)
    measures.push_back(
        meter.measure(shown.view(), flat_patch(disc.u, disc.v), {0, 0, kRadiusMm, kMarginMm}, {}, kBlurPx));
  const auto ground = common_ground(measures);
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(ground[c], kGround[c], 4) << c;
  EXPECT_EQ(common_ground({}), (std::array{0.0, 0.0, 0.0}));
}

TEST(DiscFit, UsesTheBestInstructionSetOfThisCpu) {
  std::vector<std::string> best;
  for (const std::int64_t target : cpu_targets()) best.push_back(name_of_target(target));
  std::erase(best, "AVX3_DL");  // not requested: the kernel would not use it
  EXPECT_EQ(disc_kernel_target(), best.front());
}

}  // namespace
}  // namespace sslv::disc_fit_test
