// SPDX-License-Identifier: Apache-2.0
// The V4L2 backend with the kernel's test driver, vivid: two webcams that show colour bars, with controls to
// inject faults.
#include "base/clock.h"
#include "capture/camera_thread.h"
#include "capture/v4l2/v4l2.h"
#include "image/color.h"

#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <thread>

#include <fmt/format.h>
#include <gmock/gmock.h>

namespace sslv {
namespace {

using std::chrono::milliseconds;
using ::testing::Contains;
using ::testing::HasSubstr;

constexpr milliseconds kSoon{20'000};  // the machine is emulated
constexpr const char* kFirst = "platform:vivid-000";
constexpr const char* kSecond = "platform:vivid-001";

std::unique_ptr<Source> open(Json options = Json::object()) {
  const Json defaults{{"camera", kFirst}, {"width", 640}, {"height", 480}, {"frame_rate_hz", 25}};
  for (const auto& [key, value] : defaults.items()) {
    if (!options.contains(key)) options[key] = value;
  }
  return v4l2_backend().open(v4l2_backend().complete(options, ""), {});
}

std::string refusal(const Json& options) {
  try {
    open(options);
  } catch (const CaptureError& error) {
    return error.what();
  }
  return "no error";
}

CapturedImage next_picture(Source& source) {
  CapturedImage image;
  std::string problem;
  EXPECT_EQ(source.next(image, problem, kSoon), CaptureStatus::kImage) << problem;
  return image;
}

/// The first status other than an image, within 50 frames.
CaptureStatus first_other_than_a_picture(Source& source, std::string& problem) {
  CaptureStatus status = CaptureStatus::kImage;
  for (int i = 0; i < 50 && status == CaptureStatus::kImage; ++i) {
    CapturedImage image;
    status = source.next(image, problem, kSoon);
  }
  return status;
}

/// The colour of the 2x2 block at even x and y.
Rgb color_at(const ImageView& view, int x, int y) {
  const std::uint8_t* row = view.row(y);
  const auto bayer = [&](int red_x, int red_y) -> Rgb {
    return {view.row(y + red_y)[x + red_x], view.row(y + red_y)[x + 1 - red_x],
            view.row(y + 1 - red_y)[x + 1 - red_x]};
  };
  switch (view.format) {
    case PixelFormat::kUyvy: return to_rgb({row[2 * x + 1], row[2 * x], row[2 * x + 2]});
    case PixelFormat::kYuyv: return to_rgb({row[2 * x], row[2 * x + 1], row[2 * x + 3]});
    case PixelFormat::kRgb24: return {row[3 * x], row[3 * x + 1], row[3 * x + 2]};
    case PixelFormat::kBgr24: return {row[3 * x + 2], row[3 * x + 1], row[3 * x]};
    case PixelFormat::kMono8: return {row[x], row[x], row[x]};
    case PixelFormat::kBayerRg8: return bayer(0, 0);
    case PixelFormat::kBayerGr8: return bayer(1, 0);
    case PixelFormat::kBayerGb8: return bayer(0, 1);
    case PixelFormat::kBayerBg8: return bayer(1, 1);
  }
  return {};
}

/// White, yellow, cyan, green, magenta, red, blue, black.
void expect_color_bars(const ImageView& view) {
  ASSERT_FALSE(view.empty());
  constexpr int kMiddle = 100;  // the bars have 75 % amplitude
  for (int bar = 0; bar < 8; ++bar) {
    const Rgb color = color_at(view, (2 * bar + 1) * view.width / 16 & ~1, view.height * 3 / 4 & ~1);
    const std::string what = fmt::format("bar {}: {} {} {}", bar, color.r, color.g, color.b);
    EXPECT_EQ(color.r > kMiddle, bar == 0 || bar == 1 || bar == 4 || bar == 5) << what;
    EXPECT_EQ(color.g > kMiddle, bar < 4) << what;
    EXPECT_EQ(color.b > kMiddle, bar % 2 == 0) << what;
  }
}

class VividFormat : public testing::TestWithParam<const char*> {};

TEST_P(VividFormat, ColourBarsComeAtTheirRate) {
  const auto source = open({{"pixel_format", GetParam()}});
  next_picture(*source);
  constexpr int kPictures = 25;
  const double start_s = next_picture(*source).times.t_capture_s;
  CapturedImage last;
  for (int i = 0; i < kPictures; ++i) {
    last = next_picture(*source);
    EXPECT_EQ(last.image.view().width, 640);
    EXPECT_EQ(last.image.view().height, 480);
    EXPECT_EQ(name_of(last.image.view().format), GetParam());
    expect_color_bars(last.image.view());
  }
  const double rate_hz =
      (kPictures + static_cast<double>(source->dropped())) / (last.times.t_capture_s - start_s);
  std::printf("%s: %.2f Hz, %d dropped, sigma %.2f ms\n", GetParam(), rate_hz,
              static_cast<int>(source->dropped()), 1e3 * last.times.t_capture_sigma_s.value_or(-1));
  EXPECT_NEAR(rate_hz, 25, 1);
  EXPECT_TRUE(last.times.t_capture_sigma_s);
  EXPECT_LT(std::abs(last.times.t_capture_s - unix_time_s()), 0.5);
}

INSTANTIATE_TEST_SUITE_P(All, VividFormat,
                         testing::Values("yuyv", "uyvy", "rgb24", "bgr24", "bayer_rg8", "bayer_gr8",
                                         "bayer_gb8", "bayer_bg8"),
                         [](const auto& test) { return std::string(test.param); });

TEST(Vivid, BothAreListed) {
  std::vector<std::string> cameras;
  for (const FoundCamera& found : v4l2_backend().list()) {
    cameras.push_back(found.source.at("camera"));
    EXPECT_EQ(found.model, "vivid");
    EXPECT_THAT(found.formats, Contains("yuyv"));
  }
  EXPECT_THAT(cameras, testing::ElementsAre(kFirst, kSecond));
  EXPECT_EQ(
      refusal({{"camera", "vivid-7"}}),
      "camera \"vivid-7\": not found; available: \"platform:vivid-000\" (vivid), \"platform:vivid-001\" "
      "(vivid)");
}

TEST(Vivid, BothDeliverAtOnce) {
  const auto first = open(), second = open({{"camera", kSecond}, {"pixel_format", "rgb24"}});
  for (int i = 0; i < 5; ++i) {
    expect_color_bars(next_picture(*first).image.view());
    expect_color_bars(next_picture(*second).image.view());
  }
}

TEST(Vivid, NamesWhatItDoesNotTake) {
  EXPECT_THAT(
      refusal({{"width", 650}}),
      HasSubstr("width x height 650x480 refused: the camera set 640x480 instead; it has 320x180, 640x360, "));
  EXPECT_THAT(refusal({{"frame_rate_hz", 7}}), HasSubstr("frame_rate_hz 7 refused: the camera set "));
  EXPECT_THAT(refusal({{"pixel_format", "mjpeg"}}),
              HasSubstr("pixel_format mjpeg refused: the camera has uyvy, "));
  const auto source = open();
  EXPECT_THAT(refusal({}), HasSubstr("another program uses it"));
}

TEST(Vivid, ControlsChangeThePicture) {
  const auto source = open({{"controls", {{"brightness", 128}, {"no_such", 1}}}});
  EXPECT_THAT(source->warnings(), testing::ElementsAre("no_such: the camera has no such control"));
  Controls& controls = *source->controls();
  for (const Control& control : controls.list()) std::printf("%s\n", control_json(control).dump().c_str());
  const auto brightness_of_white = [&] {
    CapturedImage image;
    for (int i = 0; i < 12; ++i) image = next_picture(*source);  // more than the number in flight
    return int{color_at(image.image.view(), 40, 360).g};
  };
  const int before = brightness_of_white();
  controls.set("brightness", 60);
  EXPECT_LT(brightness_of_white(), before - 40);
  EXPECT_EQ(controls.get("brightness").value, 60);
  controls.set("brightness", 128);
  EXPECT_EQ(brightness_of_white(), before);
}

TEST(Vivid, EveryKindOfControlIsSet) {
  const auto source = open();
  Controls& controls = *source->controls();
  const auto set = [&](const char* name, const Json& value) {
    controls.set(name, value);
    EXPECT_EQ(controls.get(name).value, value) << name;
  };
  set("horizontal_flip", true);
  set("horizontal_flip", false);
  set("boolean", false);
  set("integer_32_bits", -5);
  set("integer_64_bits", 1LL << 40);
  set("bitmask", 0x80002000);
  set("string", "abcd");
  set("test_pattern", "100% Colorbar");
  set("test_pattern", "75% Colorbar");
  const Control numbers = controls.get("integer_menu");
  set("integer_menu", numbers.choices.back());
  controls.set("button", nullptr);
  EXPECT_THROW(controls.set("brightness", 1000), std::exception);
}

TEST(Vivid, TheStampsMomentIsKnown) {
  const auto source = open();
  const double of_the_end_s = next_picture(*source).times.t_capture_sigma_s.value_or(0);
  source->controls()->set("timestamp_source", "Start of Exposure");
  CapturedImage image;
  for (int i = 0; i < 12; ++i) image = next_picture(*source);
  const double of_the_start_s = image.times.t_capture_sigma_s.value_or(0);
  EXPECT_GT(of_the_start_s, 0);
  EXPECT_GT(of_the_end_s, of_the_start_s);  // because the transfer time is unknown
  source->controls()->set("timestamp_source", "End of Frame");
}

TEST(Vivid, ADamagedBufferIsIncomplete) {
  const auto source = open();
  source->controls()->set("inject_v4l2_buf_flag_error", nullptr);
  std::string problem;
  EXPECT_EQ(first_other_than_a_picture(*source, problem), CaptureStatus::kIncomplete);
  EXPECT_EQ(problem, "the driver reports it as damaged");
  expect_color_bars(next_picture(*source).image.view());
}

TEST(Vivid, DroppedBuffersAreCounted) {
  const auto source = open();
  source->controls()->set("percentage_of_dropped_buffers", 50);
  for (int i = 0; i < 25; ++i) next_picture(*source);
  source->controls()->set("percentage_of_dropped_buffers", 0);
  std::printf("%d dropped\n", static_cast<int>(source->dropped()));
  EXPECT_GE(source->dropped(), 5U);
}

TEST(Vivid, AFatalErrorIsALoss) {
  auto source = open();
  next_picture(*source);
  source->controls()->set("inject_fatal_streaming_error", nullptr);
  std::string problem;
  EXPECT_EQ(first_other_than_a_picture(*source, problem), CaptureStatus::kLost);
  EXPECT_EQ(problem, "camera \"platform:vivid-000\": it delivers no more images: Input/output error");
  source.reset();
  source = open();
  expect_color_bars(next_picture(*source).image.view());
}

TEST(Vivid, ADisconnectedCameraIsLost) {
  auto source = open();
  next_picture(*source);
  const std::shared_ptr<Controls> controls = source->controls();
  controls->set("disconnect", nullptr);
  std::string problem;
  EXPECT_EQ(first_other_than_a_picture(*source, problem), CaptureStatus::kLost);
  EXPECT_EQ(problem, "camera \"platform:vivid-000\": it is no longer connected");
  EXPECT_THROW(controls->list(), CaptureError);
  source.reset();
  source = open();
  expect_color_bars(next_picture(*source).image.view());
}

TEST(Vivid, RefusedStartsAndBuffersAreNamed) {
  for (const char* error : {"inject_vidioc_streamon_error", "inject_vidioc_reqbufs_error"}) {
    EXPECT_THAT(refusal({{"controls", {{error, nullptr}}}}), HasSubstr("camera \"platform:vivid-000\": "))
        << error;
  }
  const auto source = open();
  CapturedImage image = next_picture(*source);
  source->controls()->set("inject_vidioc_qbuf_error", nullptr);
  image = {};
  for (int i = 0; i < 20; ++i) next_picture(*source);  // works with one buffer fewer
}

TEST(Vivid, PicturesOutliveTheSource) {
  auto source = open();
  CapturedImage held = next_picture(*source);
  source.reset();
  expect_color_bars(held.image.view());
  source = open({{"pixel_format", "rgb24"}});
  expect_color_bars(next_picture(*source).image.view());
  expect_color_bars(held.image.view());
  held = {};
  expect_color_bars(next_picture(*source).image.view());
}

TEST(Vivid, TheCameraThreadOpensALostCameraAnew) {
  std::atomic<int> taken{0};
  CameraThread thread(
      "camera 0", {}, [] { return open(); }, [&](CapturedImage&&) { ++taken; });
  thread.start();
  const auto wait_for = [](const auto& condition) {
    const auto deadline = std::chrono::steady_clock::now() + kSoon;
    while (!condition() && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
    return condition();
  };
  ASSERT_TRUE(wait_for([&] { return taken > 3; }));
  const std::int64_t unplugged_ns = steady_ns();
  thread.controls()->set("disconnect", nullptr);
  ASSERT_TRUE(wait_for([&] { return thread.health().state == CameraState::kLost; }));
  std::printf("lost after %.0f ms: %s\n", 1e-6 * static_cast<double>(steady_ns() - unplugged_ns),
              thread.health().error.c_str());
  const int before = taken;
  EXPECT_TRUE(wait_for([&] { return taken > before + 3; })) << thread.health().error;
  std::printf("pictures again after %.0f ms\n", 1e-6 * static_cast<double>(steady_ns() - unplugged_ns));
  EXPECT_GE(thread.health().reconnects, 1U);
}

}  // namespace
}  // namespace sslv
