// SPDX-License-Identifier: Apache-2.0
#include "capture/simulator/simulator.h"

#include "base/clock.h"
#include "base/error.h"
#include "capture/simulator/simulator_camera.h"
#include "support/allocation_count.h"
#include "support/patience.h"

#include <chrono>
#include <cmath>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>

namespace sslv::simulator_test {
namespace {

using namespace std::chrono_literals;

SourceContext small_context() {
  CameraCalibration c;
  c.focal_length = 200;
  c.principal_point_x = 64;
  c.principal_point_y = 48;
  c.q0 = 1;
  c.q3 = 0;
  c.tz = 4000;
  SourceContext context;
  context.scene.camera.emplace(c);
  return context;
}

std::unique_ptr<Source> small_source(double rate_hz, const char* format = "uyvy") {
  const Backend backend = simulator_backend();
  const Json options{{"width", 128}, {"height", 96}, {"frame_rate_hz", rate_hz}, {"pixel_format", format}};
  return backend.open(backend.complete(options, "/source"), small_context());
}

TEST(Simulator, GivesPicturesOfTheAskedKind) {
  CapturedImage image;
  std::string problem;
  ASSERT_EQ(small_source(0, "bayer_gb8")->next(image, problem, test::kPatience), CaptureStatus::kImage);
  EXPECT_EQ(image.image.view().width, 128);
  EXPECT_EQ(image.image.view().height, 96);
  EXPECT_EQ(image.image.view().format, PixelFormat::kBayerGb8);
  EXPECT_EQ(image.image.view().stride_bytes, 128);
  EXPECT_FALSE(image.times.t_capture_camera_s);
  EXPECT_EQ(image.name, "");
}  // the image outlives its source

TEST(Simulator, AllocatesNothingForAPictureOnceWarm) {
  if (!counts_allocations()) GTEST_SKIP() << "the sanitizer has its own allocator";
  const auto source = small_source(0, "bayer_rg8");
  CapturedImage image;
  std::string problem;
  for (int i = 0; i < 20; ++i)
    ASSERT_EQ(source->next(image, problem, test::kPatience), CaptureStatus::kImage);
  const std::uint64_t before = allocation_count();
  for (int i = 0; i < 200; ++i)
    ASSERT_EQ(source->next(image, problem, test::kPatience), CaptureStatus::kImage);
  EXPECT_EQ(allocation_count(), before);
}

TEST(Simulator, ExposesAtWholeMultiplesOfThePeriod) {
  const auto source = small_source(50);
  CapturedImage image;
  std::string problem;
  double last_s = 0;
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(source->next(image, problem, test::kPatience), CaptureStatus::kImage);
    EXPECT_NEAR(std::remainder(image.times.t_capture_s, 0.02), 0, 1e-5);
    EXPECT_GT(image.times.t_capture_s, last_s + 0.019);
    last_s = image.times.t_capture_s;
  }
}

TEST(Simulator, QueuesAFewImagesAndCountsDrops) {
  constexpr double kRateHz = 50;
  const auto source = small_source(kRateHz);
  CapturedImage image;
  std::string problem;
  const auto next_tick = [&] {
    EXPECT_EQ(source->next(image, problem, test::kPatience), CaptureStatus::kImage);
    return std::llround(image.times.t_capture_s * kRateHz);
  };
  const auto first = next_tick();
  const auto second = next_tick();
  std::this_thread::sleep_for(200ms);  // ten periods late
  for (int taken = 2; taken < 8; ++taken) {
    const auto tick = next_tick();
    EXPECT_EQ(source->dropped(), static_cast<std::uint64_t>(tick - first - taken));
    if (taken == 2) {
      EXPECT_GE(tick, second + 4);
      EXPECT_LT(image.times.t_capture_s, unix_time_s() - 2 / kRateHz) << "none was kept";
    }
  }
}

TEST(Simulator, ReportsTimeoutsAndKeepsTheImage) {
  const auto source = small_source(0.001);
  CapturedImage image;
  std::string problem;
  // Ticks are 1000 s apart: at most one of the calls can meet one.
  int images = 0;
  for (int i = 0; i < 3; ++i) images += source->next(image, problem, 1ms) == CaptureStatus::kImage;
  EXPECT_LE(images, 1);
}

TEST(Simulator, APictureThatIsHeldIsNotDrawnOver) {
  const auto source = small_source(0);
  std::vector<CapturedImage> held;
  std::string problem;
  for (;;) {
    CapturedImage image;
    if (source->next(image, problem, test::kPatience) != CaptureStatus::kImage) break;  // no buffer is left
    held.push_back(std::move(image));
    ASSERT_LT(held.size(), 100U);
  }
  ASSERT_GE(held.size(), 4U);
  const ImageView oldest = held.front().image.view();
  const std::vector<std::uint8_t> bytes(oldest.data, oldest.data + oldest.height * oldest.stride_bytes);

  const std::uint8_t* freed = held.back().image.view().data;
  held.pop_back();
  CapturedImage image;
  ASSERT_EQ(source->next(image, problem, test::kPatience), CaptureStatus::kImage);
  EXPECT_EQ(image.image.view().data, freed);
  EXPECT_TRUE(std::equal(bytes.begin(), bytes.end(), oldest.data));
}

TEST(Simulator, FillsInDefaultsAndDeclaresThem) {
  const Backend backend = simulator_backend();
  EXPECT_EQ(backend.name, "simulator");
  const Json complete = backend.complete(Json::object(), "");
  EXPECT_EQ(complete["width"], 780);
  EXPECT_EQ(complete["pixel_format"], "uyvy");
  EXPECT_EQ(backend.complete(complete, ""), complete);
  EXPECT_EQ(backend.schema()["properties"].size(), complete.size());
}

std::string error_of(const Json& options) {
  try {
    simulator_options(options, "/cameras/0/source");
  } catch (const SettingsError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Simulator, RefusesWhatCannotBeDrawn) {
  EXPECT_EQ(error_of({{"wdith", 3}}).substr(0, 44), "/cameras/0/source/wdith: no such parameter; ");
  EXPECT_EQ(error_of({{"width", 781}}),
            "/cameras/0/source: width 781 and height 580 are not allowed; expected even values for uyvy");
  EXPECT_EQ(error_of({{"bits", 12}}),
            "/cameras/0/source/bits: 12 is not allowed with uyvy; expected 8, or a Bayer or mono format");
  EXPECT_EQ(error_of({{"width", 781}, {"pixel_format", "rgb24"}}), "no error");
  EXPECT_EQ(error_of({{"robots_blue", 7}, {"first_blue_id", 10}}),
            "/cameras/0/source/robots_blue: 7 is not allowed with first_blue_id 10; expected ids up to 15");
  EXPECT_EQ(error_of({{"touching", 3}, {"placement", "scatter"}}),
            "/cameras/0/source/touching: 3 is not allowed; expected an even number");
  EXPECT_EQ(
      error_of({{"touching", 2}}),
      "/cameras/0/source/touching: 2 is not allowed with placement paths; expected 0, or placement scatter");
  EXPECT_EQ(error_of({{"hidden_balls", 2}, {"placement", "scatter"}}),
            "/cameras/0/source/hidden_balls: 2 is not allowed with 1 balls; expected no more than these");
  EXPECT_EQ(
      error_of({{"hidden_balls", 1}, {"touching", 12}, {"placement", "scatter"}}),
      "/cameras/0/source/hidden_balls: 1 is not allowed with 12 robots, 12 of them touching; expected no "
      "more than touch none");
  EXPECT_EQ(error_of({{"covered_dots", 13}}),
            "/cameras/0/source/covered_dots: 13 is not allowed with 12 robots; expected no more than these");
  const auto swing = [](const char* points) { return Json{{"light_swing", Json::parse(points)}}; };
  EXPECT_EQ(error_of(swing("[[0, 1], [5, 0.5]]")), "no error");
  EXPECT_EQ(error_of(swing("[[0, 1]]")),
            "/cameras/0/source/light_swing: [[0.0,1.0]] is not allowed; expected no points, or at least two");
  EXPECT_EQ(error_of(swing("[[1, 1], [5, 0.5]]")),
            "/cameras/0/source/light_swing/0/0: 1.0 is not allowed; expected 0");
  EXPECT_EQ(error_of(swing("[[0, 1], [5, 0.5], [5, 1]]")),
            "/cameras/0/source/light_swing/2/0: 5.0 is not allowed; expected more than the time before");
  EXPECT_EQ(error_of(swing("[[0, 1], [5, 9]]")),
            "/cameras/0/source/light_swing/1/1: 9.0 is not allowed; expected a factor 0.05 .. 4");
}

}  // namespace
}  // namespace sslv::simulator_test
