// SPDX-License-Identifier: Apache-2.0
#include "image/jpeg.h"

#include "image/color.h"

#include <algorithm>
#include <array>
#include <memory>
#include <ostream>
#include <stdexcept>
#include <vector>

#include <gmock/gmock.h>
#include <turbojpeg.h>

namespace sslv::jpeg_test {
namespace {

using ::testing::ElementsAre;

constexpr std::array kColors{Rgb{255, 255, 255}, Rgb{30, 60, 200},  Rgb{230, 200, 20},
                             Rgb{250, 120, 0},   Rgb{220, 40, 160}, Rgb{20, 140, 50}};
constexpr int kPatches = static_cast<int>(kColors.size());

/// The chart: vertical bars, each of one colour.
Rgb color_at(int x, int width) {
  return kColors[static_cast<std::size_t>(x * kPatches / width)];
}

struct Picture {
  std::vector<std::uint8_t> bytes;
  ImageView view;
};

/// The chart as a camera with this format sends it, with `padding` garbage bytes after each row.
Picture chart(PixelFormat format, int width, int height, int padding = 0) {
  Picture out;
  const int stride = width * bytes_per_pixel(format) + padding;
  out.bytes.assign(static_cast<std::size_t>(stride) * height, 0x77);
  for (int y = 0; y < height; ++y) {
    std::uint8_t* row = out.bytes.data() + static_cast<std::ptrdiff_t>(y) * stride;
    for (int x = 0; x < width; ++x) {
      const Rgb rgb = color_at(x, width);
      const Yuv yuv = to_yuv(rgb);
      const Yuv pair = to_yuv(color_at(x & ~1, width));
      const auto bayer = [&](int red_x, int red_y) {
        if (x % 2 == red_x && y % 2 == red_y) return rgb.r;
        return x % 2 != red_x && y % 2 != red_y ? rgb.b : rgb.g;
      };
      switch (format) {
        case PixelFormat::kUyvy:
          row[2 * x] = x % 2 ? pair.v : pair.u;
          row[2 * x + 1] = yuv.y;
          break;
        case PixelFormat::kYuyv:
          row[2 * x] = yuv.y;
          row[2 * x + 1] = x % 2 ? pair.v : pair.u;
          break;
        case PixelFormat::kRgb24: row[3 * x] = rgb.r, row[3 * x + 1] = rgb.g, row[3 * x + 2] = rgb.b; break;
        case PixelFormat::kBgr24: row[3 * x] = rgb.b, row[3 * x + 1] = rgb.g, row[3 * x + 2] = rgb.r; break;
        case PixelFormat::kMono8: row[x] = yuv.y; break;
        case PixelFormat::kBayerRg8: row[x] = bayer(0, 0); break;
        case PixelFormat::kBayerGr8: row[x] = bayer(1, 0); break;
        case PixelFormat::kBayerGb8: row[x] = bayer(0, 1); break;
        case PixelFormat::kBayerBg8: row[x] = bayer(1, 1); break;
      }
    }
  }
  out.view = {out.bytes.data(), width, height, stride, format};
  return out;
}

struct Decoded {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
  Rgb at(int x, int y) const {
    const std::size_t i = 3 * (static_cast<std::size_t>(y) * width + x);
    return {rgb[i], rgb[i + 1], rgb[i + 2]};
  }
};

Decoded decode(std::span<const std::uint8_t> jpeg) {
  const std::unique_ptr<void, int (*)(void*)> handle(tjInitDecompress(), tjDestroy);
  Decoded out;
  int subsampling = 0, colorspace = 0;
  const auto size = static_cast<unsigned long>(jpeg.size());
  if (tjDecompressHeader3(handle.get(), jpeg.data(), size, &out.width, &out.height, &subsampling,
                          &colorspace)) {
    throw std::runtime_error(tjGetErrorStr2(handle.get()));
  }
  out.rgb.resize(static_cast<std::size_t>(out.width) * out.height * 3);
  if (tjDecompress2(handle.get(), jpeg.data(), size, out.rgb.data(), out.width, 0, out.height, TJPF_RGB, 0)) {
    throw std::runtime_error(tjGetErrorStr2(handle.get()));
  }
  return out;
}

int difference(Rgb a, Rgb b) {
  return std::max({std::abs(a.r - b.r), std::abs(a.g - b.g), std::abs(a.b - b.b)});
}

class JpegOfFormat : public testing::TestWithParam<PixelFormat> {};

/// The middle of each bar keeps its colour at any scale.
TEST_P(JpegOfFormat, KeepsSizeAndColours) {
  const Picture picture = chart(GetParam(), 384, 96, 10);
  JpegEncoder encoder;
  for (const int width : {384, 301, 300, 193, 192, 100, 96}) {
    const Decoded decoded = decode(encoder.encode(picture.view, width, 95));
    ASSERT_EQ(decoded.width, width);
    ASSERT_EQ(decoded.height, width / 4);
    for (int bar = 0; bar < kPatches; ++bar) {
      const Rgb color = kColors[static_cast<std::size_t>(bar)];
      const std::uint8_t grey = to_yuv(color).y;
      const Rgb expected = GetParam() == PixelFormat::kMono8 ? Rgb{grey, grey, grey} : color;
      const Rgb seen = decoded.at((2 * bar + 1) * width / (2 * kPatches), decoded.height / 2);
      EXPECT_LE(difference(seen, expected), 6) << "width " << width << ", bar " << bar << ": " << int{seen.r}
                                               << ' ' << int{seen.g} << ' ' << int{seen.b};
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, JpegOfFormat,
                         testing::Values(PixelFormat::kUyvy, PixelFormat::kYuyv, PixelFormat::kRgb24,
                                         PixelFormat::kBgr24, PixelFormat::kMono8, PixelFormat::kBayerRg8,
                                         PixelFormat::kBayerGr8, PixelFormat::kBayerGb8,
                                         PixelFormat::kBayerBg8),
                         [](const auto& test) { return std::string(name_of(test.param)); });

TEST(Jpeg, NeverScalesUp) {
  const Picture picture = chart(PixelFormat::kUyvy, 48, 20);
  JpegEncoder encoder;
  const Decoded decoded = decode(encoder.encode(picture.view, 4000, 80));
  EXPECT_THAT((std::array{decoded.width, decoded.height}), ElementsAre(48, 20));
}

TEST(Jpeg, ShrinksToOnePixel) {
  for (const PixelFormat format : {PixelFormat::kUyvy, PixelFormat::kRgb24, PixelFormat::kBayerGb8}) {
    const Picture picture = chart(format, 48, 700);
    JpegEncoder encoder;
    const Decoded decoded = decode(encoder.encode(picture.view, 0, 80));
    EXPECT_THAT((std::array{decoded.width, decoded.height}), ElementsAre(1, 15)) << name_of(format);
  }
}

/// Scaling down averages pixels: fine black and white lines become grey. Picking single pixels would lose
/// lines.
TEST(Jpeg, AveragesFineDetail) {
  std::vector<std::uint8_t> bytes(64 * 64);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = i % 2 ? 255 : 0;
  JpegEncoder encoder;
  const Decoded decoded = decode(encoder.encode({bytes.data(), 64, 64, 64, PixelFormat::kMono8}, 16, 95));
  EXPECT_LE(difference(decoded.at(8, 8), Rgb{128, 128, 128}), 2);
}

TEST(Jpeg, SmallerQualityIsSmallerFile) {
  const Picture picture = chart(PixelFormat::kRgb24, 384, 96);
  JpegEncoder encoder;
  const std::size_t fine = encoder.encode(picture.view, 384, 95).size();
  EXPECT_LT(encoder.encode(picture.view, 384, 30).size(), fine);
}

/// Alternating columns of red and grey, each a pixel wide.
TEST(Jpeg, FullChromaKeepsEdges) {
  constexpr Rgb kRed{255, 0, 0}, kGrey{80, 80, 80};
  std::vector<std::uint8_t> bytes;
  for (int i = 0; i < 16 * 16; ++i) {
    const Rgb color = i % 2 ? kGrey : kRed;
    bytes.insert(bytes.end(), {color.r, color.g, color.b});
  }
  const ImageView picture{bytes.data(), 16, 16, 48, PixelFormat::kRgb24};
  JpegEncoder encoder;
  const Decoded full = decode(encoder.encode(picture, 16, 95, Chroma::kFull));
  EXPECT_LE(difference(full.at(8, 8), kRed), 20);
  EXPECT_LE(difference(full.at(9, 8), kGrey), 20);
  const Decoded halved = decode(encoder.encode(picture, 16, 95, Chroma::kHalved));
  EXPECT_GT(difference(halved.at(9, 8), kGrey), 60);
}

/// Bars keep their colour up to the edge in any Bayer order, because the mirrored border keeps the pattern.
TEST(Jpeg, BayerBordersKeepTheirColour) {
  for (const PixelFormat format :
       {PixelFormat::kBayerRg8, PixelFormat::kBayerGr8, PixelFormat::kBayerGb8, PixelFormat::kBayerBg8}) {
    const Picture picture = chart(format, 384, 96);
    JpegEncoder encoder;
    const Decoded decoded = decode(encoder.encode(picture.view, 384, 95));
    for (const int y : {0, 95}) {
      EXPECT_LE(difference(decoded.at(0, y), kColors.front()), 6) << name_of(format);
      EXPECT_LE(difference(decoded.at(383, y), kColors.back()), 6) << name_of(format);
    }
  }
}

}  // namespace
}  // namespace sslv::jpeg_test
