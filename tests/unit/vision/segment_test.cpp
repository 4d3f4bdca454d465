// SPDX-License-Identifier: Apache-2.0
// The fused stage and the plain ones must agree bit by bit, with every instruction set of this CPU.
#include "vision/segment.h"

#include "image/color.h"
#include "support/allocation_count.h"
#include "support/segment_check.h"
#include "support/simd_target.h"

#include <algorithm>
#include <array>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>

namespace sslv::segment_test {
namespace {

using Random = std::mt19937;

int between(Random& random, int low, int high) {
  return low + static_cast<int>(random() % static_cast<unsigned>(high - low + 1));
}

constexpr std::array kAllFormats{PixelFormat::kUyvy,     PixelFormat::kYuyv,     PixelFormat::kRgb24,
                                 PixelFormat::kBgr24,    PixelFormat::kMono8,    PixelFormat::kBayerRg8,
                                 PixelFormat::kBayerGr8, PixelFormat::kBayerGb8, PixelFormat::kBayerBg8};

/// An image in a buffer without slack, so that a sanitizer detects reads beyond it.
struct Picture {
  std::vector<std::uint8_t> bytes;
  ImageView view;

  Picture(PixelFormat format, int width, int height, int padding) {
    const int row_bytes = width * bytes_per_pixel(format);
    const int stride = row_bytes + padding;
    bytes.resize(static_cast<std::size_t>(stride * (height - 1) + row_bytes));
    view = {bytes.data(), width, height, stride, format};
  }
  Image image() const { return {view, nullptr, nullptr, nullptr}; }

  /// Colours a pixel, or the pair or quad that contains it.
  void set(int x, int y, Rgb c) {
    const auto at = [&](int px, int py) -> std::uint8_t& {
      return bytes[static_cast<std::size_t>(py * view.stride_bytes + px)];
    };
    const Yuv k = to_yuv(c);
    const int pair = x / 2 * 4, qx = x & ~1, qy = y & ~1;
    const auto quad = [&](int red) {
      for (int i = 0; i < 4; ++i) at(qx + i % 2, qy + i / 2) = i == red ? c.r : i == 3 - red ? c.b : c.g;
    };
    switch (view.format) {
      case PixelFormat::kUyvy: at(pair, y) = k.u, at(pair + 2, y) = k.v, at(2 * x + 1, y) = k.y; break;
      case PixelFormat::kYuyv: at(pair + 1, y) = k.u, at(pair + 3, y) = k.v, at(2 * x, y) = k.y; break;
      case PixelFormat::kRgb24: at(3 * x, y) = c.r, at(3 * x + 1, y) = c.g, at(3 * x + 2, y) = c.b; break;
      case PixelFormat::kBgr24: at(3 * x, y) = c.b, at(3 * x + 1, y) = c.g, at(3 * x + 2, y) = c.r; break;
      case PixelFormat::kMono8: at(x, y) = k.y; break;
      case PixelFormat::kBayerRg8: quad(0); break;
      case PixelFormat::kBayerGr8: quad(1); break;
      case PixelFormat::kBayerGb8: quad(2); break;
      case PixelFormat::kBayerBg8: quad(3); break;
    }
  }

  void fill(Random& random) {
    const auto noise = [&](int sigma) {
      for (auto& byte : bytes)
        byte = static_cast<std::uint8_t>(std::clamp(byte + between(random, -sigma, sigma), 0, 255));
    };
    const auto carpet = [&] {
      for (int y = 0; y < view.height; ++y) {
        for (int x = 0; x < view.width; ++x) set(x, y, kCarpet);
      }
    };
    const auto color = [&] { return kColors[random() % kColors.size()]; };
    switch (random() % 6) {
      case 0:  // noise
        for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
        break;
      case 1:  // one colour
        std::fill(bytes.begin(), bytes.end(), static_cast<std::uint8_t>(random()));
        break;
      case 2: {  // speckle, from hardly any to everywhere
        carpet();
        const unsigned rarity = 1U << random() % 10;
        for (int y = 0; y < view.height; ++y) {
          for (int x = 0; x < view.width; ++x) {
            if (random() % rarity == 0) set(x, y, color());
          }
        }
        break;
      }
      case 3: {  // stripes
        carpet();
        const int period = between(random, 1, 70);
        for (int y = 0; y < view.height; ++y) {
          for (int x = 0; x < view.width; ++x) {
            if ((x / period + y / period) % 2 == 0)
              set(x, y, kColors[static_cast<std::size_t>(x / period) % 6]);
          }
        }
        break;
      }
      default:  // a field with things on it
        carpet();
        for (int i = between(random, 0, 12); i > 0; --i) {
          const Rgb c = color();
          const int radius = between(random, 0, 9);
          const int cx = between(random, 0, view.width - 1), cy = between(random, 0, view.height - 1);
          for (int y = std::max(0, cy - radius); y <= std::min(view.height - 1, cy + radius); ++y) {
            for (int x = std::max(0, cx - radius); x <= std::min(view.width - 1, cx + radius); ++x) {
              if ((x - cx) * (x - cx) + (y - cy) * (y - cy) <= radius * radius) set(x, y, c);
            }
          }
        }
        noise(between(random, 0, 12));
    }
  }
};

Mask random_mask(Random& random, int width, int height) {
  MaskSettings settings;
  const auto polygon = [&] {
    MaskPolygon made;
    for (int i = between(random, 3, 6); i > 0; --i)
      made.points.push_back({between(random, -4, width + 4) * 1.0, between(random, -4, height + 4) * 0.5});
    return made;
  };
  for (int i = between(random, 0, 2); i > 0; --i) settings.include.push_back(polygon());
  for (int i = between(random, 0, 2); i > 0; --i) settings.exclude.push_back(polygon());
  return Mask(settings);
}

int random_width(Random& random) {
  switch (random() % 4) {
    case 0: return between(random, 1, 80);
    case 1: return between(random, 1, 5) * 64 + between(random, -2, 2);
    case 2: return between(random, 60, 400);
    default: return random() % 8 == 0 ? between(random, 4090, 4300) : between(random, 64, 200);
  }
}

class SegmentOnTarget : public testing::TestWithParam<std::int64_t> {
 protected:
  void SetUp() override {
    if (search_runs_target() != name_of_target(GetParam())) GTEST_SKIP() << "this compiler does not make it";
  }
  OnlyTarget only_{GetParam()};
};

TEST_P(SegmentOnTarget, EqualsThePlainStages) {
  Random random(static_cast<Random::result_type>(GetParam() ^ GetParam() >> 32));
  PlainSegmentation plain;
  RunList runs;
  RegionList regions;
  for (int i = 0; i < 1500; ++i) {
    const PixelFormat format = kAllFormats[static_cast<std::size_t>(i) % kAllFormats.size()];
    const int cell = is_bayer(format) ? 2 : 1;
    int width = random_width(random) * cell;
    if (is_yuv422(format)) width += width % 2;
    const int rows = width > 1000 ? 3 : i % 8 == 0 ? 150 : 20;
    const int height = between(random, 1, rows) * cell;
    const Mask mask = random() % 2 == 0 ? Mask() : random_mask(random, width, height);
    Segment::Params params;
    params.regions.connectivity = random() % 2 == 0 ? Connectivity::kFour : Connectivity::kEight;
    params.regions.min_cells = between(random, 1, 3);
    params.runs.max_runs = random() % 4 == 0 ? between(random, 1, 2000) : 65'536;
    params.regions.max_regions = random() % 4 == 0 ? between(random, 1, 20) : 20'000;
    params.threads = i % 50 == 0 ? 3 : 1;
    const int padding = random() % 2 == 0 ? 0 : between(random, 1, 70);

    // Several images and tables in turn: the background is learnt from the first images.
    Segment segment;
    auto lut = test_luts()[random() % test_luts().size()];
    for (int k = 0; k < 3; ++k) {
      Picture picture(format, width, height, padding);
      picture.fill(random);
      if (random() % 3 == 0) lut = test_luts()[random() % test_luts().size()];
      const Image image = picture.image();
      plain.process(params, *lut, mask, image);
      segment.process(params, *lut, mask, image, runs, regions);
      ASSERT_EQ(difference(plain, runs, regions), "")
          << "case " << i << "." << k << ": " << name_of(format) << " " << width << " x " << height
          << " padding " << padding;
    }
  }
}

TEST_P(SegmentOnTarget, EqualsThePlainStagesAtEveryEdgeOfAMask) {
  Random random(3);
  PlainSegmentation plain;
  RunList runs;
  RegionList regions;
  for (const PixelFormat format : {PixelFormat::kUyvy, PixelFormat::kRgb24, PixelFormat::kBayerGb8}) {
    for (const std::size_t lut : {1U, 2U}) {
      Picture picture(format, 264, 4, 0);
      for (int y = 0; y < 4; ++y) {
        for (int x = 0; x < 264; ++x) picture.set(x, y, random() % 40 == 0 ? kColors[random() % 6] : kCarpet);
      }
      const Image image = picture.image();
      Segment segment;
      for (int left = 0; left < 264; ++left) {
        const int right = between(random, left, 264);
        const MaskPolygon strip{
            {{left - 0.5, -1.0}, {right - 0.5, -1.0}, {right - 0.5, 9.0}, {left - 0.5, 9.0}}};
        const Mask masks[] = {Mask({{strip}, {}}), Mask({{}, {strip}})};
        for (const Mask& mask : masks) {
          plain.process({}, *test_luts()[lut], mask, image);
          segment.process({}, *test_luts()[lut], mask, image, runs, regions);
          ASSERT_EQ(difference(plain, runs, regions), "")
              << name_of(format) << " " << left << " .. " << right;
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Cpu, SegmentOnTarget, testing::ValuesIn(cpu_targets()),
                         [](const auto& param) { return name_of_target(param.param); });

TEST(Segment, UsesTheBestInstructionSetOfThisCpu) {
  EXPECT_EQ(search_runs_target(), name_of_target(cpu_targets().front()));
}

TEST(Segment, ATableTakesEffectWithTheNextFrame) {
  Picture picture(PixelFormat::kUyvy, 780, 60, 0);
  Random random(1);
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 780; ++x) picture.set(x, y, kCarpet);
  }
  const Image image = picture.image();
  Segment segment;
  RunList runs;
  RegionList regions;
  for (int i = 0; i < 20; ++i) {
    const bool carpet_is_labelled = i % 2 == 1;
    segment.process({}, *test_luts()[carpet_is_labelled ? 2 : 1], Mask(), image, runs, regions);
    ASSERT_EQ(regions.regions.size(), carpet_is_labelled ? 1U : 0U) << "frame " << i;
  }
}

TEST(Segment, AllocatesNothingOnceItRuns) {
  if (!counts_allocations()) GTEST_SKIP() << "the sanitizer has its own allocator";
  Random random(2);
  std::vector<Picture> pictures;
  for (int i = 0; i < 6; ++i) pictures.emplace_back(PixelFormat::kUyvy, 400, 120, 0).fill(random);
  std::vector<Image> images;
  for (const Picture& picture : pictures) images.push_back(picture.image());
  const Mask mask;
  Segment segment;
  RunList runs;
  RegionList regions;
  const auto run = [&](std::size_t frames) {
    for (std::size_t i = 0; i < frames; ++i)
      segment.process({}, *test_luts()[1 + i / 100 % 2], mask, images[i % images.size()], runs, regions);
  };
  run(200);
  const std::uint64_t before = allocation_count();
  run(1000);
  EXPECT_EQ(allocation_count() - before, 0u);
}

TEST(Segment, SharesAPictureBetweenThreads) {
  Random random(5);
  Picture picture(PixelFormat::kRgb24, 300, 200, 0);
  PlainSegmentation plain;
  RunList runs;
  RegionList regions;
  Segment segment;
  for (int i = 0; i < 60; ++i) {
    picture.fill(random);
    const Image image = picture.image();
    Segment::Params params;
    params.threads = 1 + i / 10 % 4;
    params.runs.max_runs = i % 2 == 0 ? 65'536 : 900;
    plain.process(params, *test_luts()[1], Mask(), image);
    segment.process(params, *test_luts()[1], Mask(), image, runs, regions);
    ASSERT_EQ(difference(plain, runs, regions), "") << i;
  }
}

}  // namespace
}  // namespace sslv::segment_test
