// SPDX-License-Identifier: Apache-2.0
#include "capture/simulator/simulator_sensor.h"

#include "image/color.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace sslv::simulator_sensor_test {
namespace {

constexpr int kSide = 32;

SimulatorOptions options_of(PixelFormat format) {
  SimulatorOptions options;
  options.width = options.height = kSide;
  options.pixel_format = format;
  options.noise_sigma = 0;
  options.blur_sigma_px = 0;
  return options;
}

void set(LightPicture& light, int x, int y, int r, int g, int b) {
  const int grey = LightPicture::kPerGrey;
  std::uint16_t* p = light.at(x, y);
  p[0] = static_cast<std::uint16_t>(r * grey);
  p[1] = static_cast<std::uint16_t>(g * grey);
  p[2] = static_cast<std::uint16_t>(b * grey);
}

LightPicture even_light(int r, int g, int b) {
  LightPicture light(kSide, kSide);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) set(light, x, y, r, g, b);
  }
  return light;
}

std::vector<std::uint8_t> developed(const SimulatorOptions& options, const LightPicture& light) {
  SimulatorSensor sensor(options, 0);
  std::vector<std::uint8_t> picture(sensor.picture_bytes());
  sensor.develop(light, {0, 0, kSide, kSide}, picture.data());
  return picture;
}

TEST(SimulatorSensor, ConvertsColoursLikeTheService) {
  constexpr Rgb kColors[] = {{200, 60, 20}, {10, 250, 90}, {33, 44, 180}, {255, 255, 255}, {0, 0, 0}};
  for (const Rgb& c : kColors) {
    const LightPicture light = even_light(c.r, c.g, c.b);
    const Yuv yuv = to_yuv(c);
    const auto uyvy = developed(options_of(PixelFormat::kUyvy), light);
    EXPECT_NEAR(uyvy[0], yuv.u, 1);
    EXPECT_NEAR(uyvy[1], yuv.y, 1);
    EXPECT_NEAR(uyvy[2], yuv.v, 1);
    EXPECT_NEAR(uyvy[3], yuv.y, 1);
    const auto yuyv = developed(options_of(PixelFormat::kYuyv), light);
    EXPECT_NEAR(yuyv[1], yuv.u, 1);
    EXPECT_NEAR(yuyv[2], yuv.y, 1);
    EXPECT_NEAR(yuyv[3], yuv.v, 1);
    EXPECT_NEAR(developed(options_of(PixelFormat::kMono8), light)[5], yuv.y, 1);
    const auto bgr = developed(options_of(PixelFormat::kBgr24), light);
    EXPECT_EQ(bgr[3], c.b);
    EXPECT_EQ(bgr[4], c.g);
    EXPECT_EQ(bgr[5], c.r);
  }
}

TEST(SimulatorSensor, AveragesTheColourOfPairs) {
  LightPicture light = even_light(0, 0, 0);
  set(light, 0, 0, 200, 60, 20);
  const auto uyvy = developed(options_of(PixelFormat::kUyvy), light);
  const Yuv left = to_yuv({200, 60, 20});
  EXPECT_NEAR(uyvy[0], (left.u + 128) / 2.0, 1);
  EXPECT_NEAR(uyvy[1], left.y, 1);
  EXPECT_NEAR(uyvy[2], (left.v + 128) / 2.0, 1);
  EXPECT_EQ(uyvy[3], 0);
}

TEST(SimulatorSensor, BayerFormatsAreNamedAfterTheirFirstPixels) {
  const LightPicture light = even_light(10, 20, 30);
  struct Case {
    PixelFormat format;
    std::array<int, 4> quad;
  };
  for (const Case& c :
       {Case{PixelFormat::kBayerRg8, {10, 20, 20, 30}}, Case{PixelFormat::kBayerGr8, {20, 10, 30, 20}},
        Case{PixelFormat::kBayerGb8, {20, 30, 10, 20}}, Case{PixelFormat::kBayerBg8, {30, 20, 20, 10}}}) {
    const auto picture = developed(options_of(c.format), light);
    EXPECT_EQ((std::array<int, 4>{picture[0], picture[1], picture[kSide], picture[kSide + 1]}), c.quad)
        << name_of(c.format);
  }
}

TEST(SimulatorSensor, SaturatesBeforeColoursAreMixed) {
  // Overexposed orange turns yellow: red is clipped while green still rises.
  const auto uyvy = developed(options_of(PixelFormat::kUyvy), even_light(600, 250, 0));
  const Yuv yellow = to_yuv({255, 250, 0});
  EXPECT_NEAR(uyvy[0], yellow.u, 1);
  EXPECT_NEAR(uyvy[2], yellow.v, 1);
}

TEST(SimulatorSensor, BlurSpreadsLightByItsSigma) {
  LightPicture light = even_light(0, 0, 0);
  for (int y = 14; y < 17; ++y) {
    for (int x = 14; x < 17; ++x) set(light, x, y, 250, 0, 0);
  }
  SimulatorOptions options = options_of(PixelFormat::kRgb24);
  options.blur_sigma_px = 1.5;
  const auto picture = developed(options, light);
  double sum = 0, variance_x = 0, variance_y = 0;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const int at = 3 * (y * kSide + x);
      const double red = picture[at];
      sum += red;
      variance_x += red * (x - 15) * (x - 15);
      variance_y += red * (y - 15) * (y - 15);
    }
  }
  EXPECT_NEAR(sum, 9 * 250, 25);
  // A box of 3 has a variance of 2/3.
  EXPECT_NEAR(variance_x / sum, 1.5 * 1.5 + 2.0 / 3, 0.15);
  EXPECT_NEAR(variance_y / sum, variance_x / sum, 1e-9);
}

TEST(SimulatorSensor, ABoxDevelopsAsInTheWholePicture) {
  LightPicture light = even_light(20, 80, 40);
  set(light, 13, 9, 250, 200, 100);
  set(light, 0, 31, 10, 200, 250);
  for (const PixelFormat format : {PixelFormat::kUyvy, PixelFormat::kRgb24, PixelFormat::kBayerGr8}) {
    SimulatorOptions options = options_of(format);
    options.blur_sigma_px = 0.8;
    const auto whole = developed(options, light);
    SimulatorSensor sensor(options, 0);
    auto picture = developed(options, even_light(20, 80, 40));
    for (const DrawnBox& box : {DrawnBox{13, 9, 14, 10}, DrawnBox{0, 31, 1, 32}}) {
      const DrawnBox reached = sensor.reached_from(box);
      EXPECT_EQ(reached.left % 2, 0);
      EXPECT_EQ(reached.right % 2, 0);
      sensor.develop(light, reached, picture.data());
    }
    EXPECT_EQ(picture, whole) << name_of(format);
  }
}

TEST(SimulatorSensor, YuvNoiseIsThatOfTheColoursItIsMixedFrom) {
  for (const PixelFormat format : {PixelFormat::kUyvy, PixelFormat::kYuyv}) {
    SCOPED_TRACE(std::string(name_of(format)));
    SimulatorOptions options = options_of(format);
    options.width = options.height = 256;
    options.noise_sigma = 10;
    SimulatorSensor sensor(options, 0);
    const std::vector<std::uint8_t> clean(sensor.picture_bytes(), 128);
    std::vector<std::uint8_t> noisy(clean.size());
    sensor.add_noise(clean.data(), noisy.data());
    const std::size_t y0 = format == PixelFormat::kUyvy ? 1 : 0, u0 = 1 - y0;
    double y = 0, u = 0, v = 0, y_u = 0, y_y = 0;
    for (std::size_t i = 0; i < noisy.size(); i += 4) {
      const auto at = [&](std::size_t sample) { return noisy[i + sample] - 128.0; };
      y += (at(y0) * at(y0) + at(y0 + 2) * at(y0 + 2)) / 2;
      u += at(u0) * at(u0);
      v += at(u0 + 2) * at(u0 + 2);
      y_u += at(y0) * at(u0);
      y_y += at(y0) * at(y0 + 2);
    }
    const auto units = static_cast<double>(noisy.size()) / 4;
    // Chroma is the mean of two pixels', each a weighted sum of its colours.
    EXPECT_NEAR(std::sqrt(y / units), 6.69, 0.15);
    EXPECT_NEAR(std::sqrt(u / units), 4.41, 0.1);
    EXPECT_NEAR(std::sqrt(v / units), 4.65, 0.1);
    EXPECT_NEAR(y_u / units, -9.4, 1.2);  // blue raises U; red and green, most of Y, lower it
    EXPECT_NEAR(y_y / units, 0, 1.5);
  }
}

TEST(SimulatorSensor, DeepPixelsCarryWhatEightBitsLeave) {
  LightPicture light = even_light(0, 0, 0);
  for (int x = 0; x < kSide; ++x)
    light.at(x, 0)[0] = static_cast<std::uint16_t>(10 * LightPicture::kPerGrey + 2 * x);
  SimulatorOptions options = options_of(PixelFormat::kBayerRg8);
  options.bits = 12;
  SimulatorSensor sensor(options, 0);
  const std::size_t plane = sensor.plane_bytes();
  ASSERT_EQ(sensor.picture_bytes(), 2 * plane);
  const auto clean = developed(options, light);
  std::vector<std::uint8_t> picture(clean.size());
  sensor.add_noise(clean.data(), picture.data());
  for (std::size_t x = 0; x < kSide; x += 2) {
    const double level = 10 + static_cast<double>(x) / 32;
    EXPECT_EQ(picture[x], 10) << x;
    EXPECT_EQ(picture[plane + x], static_cast<int>(16 * (level - 10)) * 16) << x;
  }
}

TEST(SimulatorSensor, NoiseOfDeepPixelsIsFinerThanALevel) {
  SimulatorOptions options = options_of(PixelFormat::kMono8);
  options.width = options.height = 128;
  options.bits = 12;
  options.noise_sigma = 0.3;
  SimulatorSensor sensor(options, 0);
  const std::size_t plane = sensor.plane_bytes();
  std::vector<std::uint8_t> clean(2 * plane, 100), noisy(clean.size());
  sensor.add_noise(clean.data(), noisy.data());
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < plane; ++i) {
    const double off = noisy[i] + noisy[plane + i] / 256.0 - (100 + 100 / 256.0);
    sum += off;
    squares += off * off;
  }
  const auto count = static_cast<double>(plane);
  EXPECT_NEAR(sum / count, -1.0 / 32, 0.01);
  EXPECT_NEAR(std::sqrt(squares / count), 0.3, 0.01);
  // White stays white, black stays black.
  for (const int level : {0, 255}) {
    std::fill_n(clean.begin(), plane, static_cast<std::uint8_t>(level));
    std::fill_n(clean.begin() + static_cast<std::ptrdiff_t>(plane), plane, std::uint8_t{0});
    sensor.add_noise(clean.data(), noisy.data());
    const auto kept = std::count_if(noisy.begin(), noisy.begin() + static_cast<std::ptrdiff_t>(plane),
                                    [&](std::uint8_t value) { return value == level; });
    EXPECT_GT(kept, static_cast<long>(plane) * (level == 0 ? 95 : 45) / 100) << level;
  }
}

TEST(SimulatorSensor, NoiseStaysWithinBytes) {
  SimulatorOptions options = options_of(PixelFormat::kMono8);
  options.noise_sigma = 20;
  SimulatorSensor sensor(options, 0);
  for (const int level : {0, 255}) {
    const std::vector<std::uint8_t> clean(sensor.picture_bytes(), static_cast<std::uint8_t>(level));
    std::vector<std::uint8_t> noisy(clean.size());
    sensor.add_noise(clean.data(), noisy.data());
    int kept = 0, far = 0;
    for (const std::uint8_t value : noisy) {
      kept += value == level;
      far += std::abs(value - level) > 127;
    }
    EXPECT_GT(kept, 400);  // half of the 1024 pixels are clipped
    EXPECT_LT(kept, 650);
    EXPECT_EQ(far, 0);
  }
}

}  // namespace
}  // namespace sslv::simulator_sensor_test
