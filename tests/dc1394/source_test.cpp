// SPDX-License-Identifier: Apache-2.0
#include "capture/camera_thread.h"
#include "dc1394/iidc_camera.h"
#include "support/allocation_count.h"
#include "support/patience.h"

#include <algorithm>
#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <mutex>
#include <thread>

namespace sslv {
namespace {

using fake_iidc::colour_at;
using fake_iidc::send;
using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Checks that the image shows what the sensor saw; `left` and `top` are its origin on the sensor.
void expect_scene(const ImageView& view, int number, int left = 0, int top = 0) {
  ASSERT_FALSE(view.empty());
  int wrong = 0;
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      const Rgb seen = colour_at(x + left, y + top, number);
      const Yuv yuv = to_yuv(seen);
      const std::uint8_t* row = view.row(y);
      bool same = false;
      switch (view.format) {
        case PixelFormat::kUyvy: {
          const std::uint8_t* pair = row + 4 * (x / 2);
          same = Yuv{pair[x % 2 == 0 ? 1 : 3], pair[0], pair[2]} == yuv;
          break;
        }
        case PixelFormat::kRgb24: same = Rgb{row[3 * x], row[3 * x + 1], row[3 * x + 2]} == seen; break;
        case PixelFormat::kMono8: same = row[x] == yuv.y; break;
        case PixelFormat::kBayerGr8:
          same = row[x] == (x % 2 == y % 2 ? seen.g : y % 2 == 0 ? seen.r : seen.b);
          break;
        default: break;
      }
      wrong += !same;
    }
  }
  EXPECT_EQ(wrong, 0) << "pixels of a " << name_of(view.format) << " picture";
}

// ---- modes and formats

TEST_F(IidcCamera, OpensTheWholeSensorInColourByItself) {
  const auto source = open();
  const int number = send(kGuid);
  const CapturedImage image = next_picture(*source);
  EXPECT_EQ(image.image.view().width, 780);
  EXPECT_EQ(image.image.view().height, 580);
  EXPECT_EQ(image.image.view().format, PixelFormat::kUyvy);
  expect_scene(image.image.view(), number);
  EXPECT_EQ(fake_iidc::state_of(kGuid).speed, DC1394_ISO_SPEED_800);
}

/// The low bits of the fake camera's 16-bit pixels are the inverted top two of its 8 bits.
void expect_low_bits(const ImageView& view, bool is_deep) {
  ASSERT_EQ(view.to_low_bits, is_deep ? std::ptrdiff_t{view.width} * view.height : 0);
  for (std::ptrdiff_t i = 0; i < view.to_low_bits; ++i)
    ASSERT_EQ(view.data[i + view.to_low_bits], static_cast<std::uint8_t>(~view.data[i]) & 0xC0) << i;
}

struct Format {
  const char* name;
  PixelFormat arrives_as;
};
class IidcFormat : public IidcCamera, public testing::WithParamInterface<Format> {};

TEST_P(IidcFormat, ArrivesWholeWithItsColours) {
  const auto source = open({{"mode", "format7_0"}, {"pixel_format", GetParam().name}});
  for (int i = 0; i < 3; ++i) {
    const int number = send(kGuid);
    const CapturedImage image = next_picture(*source);
    EXPECT_EQ(image.image.view().format, GetParam().arrives_as);
    expect_scene(image.image.view(), number);
    expect_low_bits(image.image.view(), std::string_view(GetParam().name).ends_with("16"));
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, IidcFormat,
    testing::Values(Format{"yuv411", PixelFormat::kUyvy}, Format{"yuv422", PixelFormat::kUyvy},
                    Format{"yuv444", PixelFormat::kUyvy}, Format{"rgb8", PixelFormat::kRgb24},
                    Format{"mono8", PixelFormat::kMono8}, Format{"mono16", PixelFormat::kMono8},
                    Format{"raw8", PixelFormat::kBayerGr8}, Format{"raw16", PixelFormat::kBayerGr8}),
    [](const auto& tested) { return std::string(tested.param.name); });

TEST_F(IidcCamera, EveryFixedModeArrivesWhole) {
  fake_iidc::Camera camera = fake_iidc::league_camera(kGuid);
  camera.format7.clear();
  camera.native.clear();
  const std::vector<dc1394framerate_t> rates{DC1394_FRAMERATE_7_5};
  for (int mode = DC1394_VIDEO_MODE_MIN; mode < DC1394_VIDEO_MODE_EXIF; ++mode)
    camera.native[static_cast<dc1394video_mode_t>(mode)] = rates;
  fake_iidc::clear();
  fake_iidc::plug_in(camera);
  const std::vector<std::string> modes = dc1394_backend().list().at(0).formats;
  EXPECT_EQ(modes.size(), 23U);
  for (const std::string& mode : modes) {
    SCOPED_TRACE(mode);
    const auto source = open({{"mode", mode}, {"ring_frames", 3}});
    const int number = send(kGuid);
    const CapturedImage image = next_picture(*source);
    EXPECT_TRUE(mode.starts_with(std::to_string(image.image.view().width) + "x" +
                                 std::to_string(image.image.view().height) + "_"));
    expect_scene(image.image.view(), number);
  }
}

TEST_F(IidcCamera, WithoutFormat7TakesTheLargestPictureAtItsFastest) {
  fake_iidc::Camera camera = fake_iidc::league_camera(kGuid);
  camera.format7.clear();
  fake_iidc::clear();
  fake_iidc::plug_in(camera);
  const auto source = open();
  EXPECT_EQ(fake_iidc::state_of(kGuid).mode, DC1394_VIDEO_MODE_640x480_YUV422);
  EXPECT_EQ(fake_iidc::state_of(kGuid).rate, DC1394_FRAMERATE_60);
}

TEST_F(IidcCamera, TakesNoRateThatItsSpeedCannotCarry) {
  const auto source = open({{"mode", "640x480_yuv422"}, {"iso_speed", "400"}});
  EXPECT_EQ(fake_iidc::state_of(kGuid).rate, DC1394_FRAMERATE_30);
  EXPECT_EQ(fake_iidc::state_of(kGuid).operation, DC1394_OPERATION_MODE_LEGACY);
}

TEST_F(IidcCamera, MonoPicturesCanBeDeclaredBayer) {
  const auto source = open({{"pixel_format", "mono8"}, {"bayer_order", "rggb"}});
  send(kGuid);
  EXPECT_EQ(next_picture(*source).image.view().format, PixelFormat::kBayerRg8);
}

TEST_F(IidcCamera, AsksForTheBayerOrderThatTheCameraDoesNotSay) {
  fake_iidc::Camera camera = fake_iidc::league_camera(kGuid);
  camera.format7.at(DC1394_VIDEO_MODE_FORMAT7_0).filter.reset();
  fake_iidc::clear();
  fake_iidc::plug_in(camera);
  EXPECT_EQ(refusal({{"pixel_format", "raw8"}}),
            "camera \"000a470112345678\": bayer_order auto refused: the camera does not report it; set one "
            "of rggb, gbrg, grbg, bggr");
  EXPECT_EQ(refusal({{"pixel_format", "raw8"}, {"bayer_order", "grbg"}}), "no error");
}

// ---- part of the sensor

TEST_F(IidcCamera, ReadsAPartOfTheSensor) {
  const auto source = open(
      {{"width", 320}, {"height", 200}, {"offset_x", 24}, {"offset_y", 16}, {"packet_size_bytes", 4000}});
  const int number = send(kGuid);
  const CapturedImage image = next_picture(*source);
  EXPECT_EQ(image.image.view().width, 320);
  EXPECT_EQ(image.image.view().height, 200);
  expect_scene(image.image.view(), number, 24, 16);
  EXPECT_EQ(fake_iidc::state_of(kGuid).format7.at(DC1394_VIDEO_MODE_FORMAT7_0).packet, 4000U);
}

TEST_F(IidcCamera, SizeFollowsTheOffset) {
  const auto source = open({{"offset_x", 40}, {"offset_y", 10}});
  send(kGuid);
  const CapturedImage image = next_picture(*source);
  EXPECT_EQ(image.image.view().width, 740);
  EXPECT_EQ(image.image.view().height, 570);
}

TEST_F(IidcCamera, RefusalsSayWhatIsAllowed) {
  const std::string camera = "camera \"000a470112345678\": ";
  EXPECT_EQ(refusal({{"width", 333}}), camera + "width 333 refused: format7_0 allows 4 .. 780 in steps of 4");
  EXPECT_EQ(refusal({{"height", 600}}),
            camera + "height 600 refused: format7_0 allows 2 .. 580 in steps of 2");
  EXPECT_EQ(refusal({{"width", 700}, {"offset_x", 100}}),
            camera + "offset_x 100 refused: format7_0 of width 700 allows 0 .. 80 in steps of 2");
  EXPECT_EQ(refusal({{"height", 100}, {"offset_y", 3}}),
            camera + "offset_y 3 refused: format7_0 of height 100 allows 0 .. 480 in steps of 2");
  EXPECT_EQ(refusal({{"offset_x", 800}}),
            camera + "offset_x 800 refused: format7_0 allows 0 .. 776 in steps of 2");
  EXPECT_EQ(
      refusal({{"packet_size_bytes", 4097}}),
      camera + "packet_size_bytes 4097 refused: format7_0 at iso_speed 800 allows 4 .. 8192 in steps of 4");
  EXPECT_EQ(
      refusal({{"packet_size_bytes", 6000}, {"iso_speed", "400"}}),
      camera + "packet_size_bytes 6000 refused: format7_0 at iso_speed 400 allows 4 .. 4096 in steps of 4");
  EXPECT_EQ(refusal({{"mode", "640x480_mono8"}, {"width", 320}}),
            camera + "width 320 refused: only Format7 modes have it; 640x480_mono8 is fixed");
  EXPECT_EQ(refusal({{"mode", "640x480_mono8"}, {"frame_rate_hz", 25}}),
            camera + "frame_rate_hz 25 refused: 640x480_mono8 at iso_speed 800 allows 30, 60");
  EXPECT_EQ(refusal({{"mode", "800x600_rgb8"}}),
            camera +
                "mode 800x600_rgb8 refused: the camera has 640x480_yuv422, 640x480_mono8, format7_0, "
                "format7_1");
  EXPECT_EQ(refusal({{"mode", "format7_1"}, {"pixel_format", "rgb8"}}),
            camera + "pixel_format rgb8 refused: format7_1 has mono8");
  EXPECT_EQ(refusal({{"frame_rate_hz", 100}}),
            camera + "frame_rate_hz 100 refused: the camera allows 1 .. 62 now");
  EXPECT_EQ(refusal({{"camera", "SSL1"}}),
            "/camera: \"SSL1\" is not allowed; expected a GUID: up to 16 hexadecimal digits");
}

TEST_F(IidcCamera, Without1394bThereIsNoSpeed800) {
  fake_iidc::Camera camera = fake_iidc::league_camera(kGuid);
  camera.can_1394b = false;
  fake_iidc::clear();
  fake_iidc::plug_in(camera);
  EXPECT_EQ(
      refusal({{"iso_speed", "800"}}),
      "camera \"000a470112345678\": iso_speed 800 refused: the camera allows 100, 200, 400; it has no 1394b");
  // The recommended packet size is limited to what the bus carries.
  EXPECT_EQ(refusal(Json::object()), "no error");
  EXPECT_EQ(fake_iidc::state_of(kGuid).format7.at(DC1394_VIDEO_MODE_FORMAT7_0).packet, 4096U);
}

TEST_F(IidcCamera, Format7TakesARateWhereTheCameraHasIt) {
  const auto source = open({{"frame_rate_hz", 50}});
  const fake_iidc::Feature rate = fake_iidc::state_of(kGuid).features.at(DC1394_FEATURE_FRAME_RATE);
  EXPECT_EQ(rate.absolute_value, 50);
  EXPECT_TRUE(rate.absolute_on);
}

TEST_F(IidcCamera, SaysWhenTheBusIsFull) {
  fake_iidc::plug_in(fake_iidc::league_camera(kOtherGuid));
  const auto first = open({{"camera", kGuidText}, {"packet_size_bytes", 8192}});
  EXPECT_THAT(refusal({{"camera", "00b09d0100112233"}, {"packet_size_bytes", 8192}}),
              HasSubstr("camera \"00b09d0100112233\": the bus has not enough bandwidth left for it"));
  EXPECT_EQ(refusal({{"camera", "00b09d0100112233"}, {"packet_size_bytes", 800}}), "no error");
}

// ---- finding

TEST_F(IidcCamera, ListsWhatThereIsToPaste) {
  fake_iidc::plug_in(fake_iidc::league_camera(kOtherGuid));
  const std::vector<FoundCamera> found = dc1394_backend().list();
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].name, "Fake Vision F-046 000a470112345678");
  EXPECT_EQ(found[0].serial, kGuidText);
  EXPECT_EQ(found[1].model, "F-046");
  EXPECT_THAT(found[0].formats,
              ElementsAre("640x480_yuv422", "640x480_mono8", "format7_0 yuv422", "format7_0 raw8",
                          "format7_0 rgb8", "format7_0 yuv411", "format7_0 yuv444", "format7_0 mono8",
                          "format7_0 raw16", "format7_0 mono16", "format7_1 mono8"));
  Json pasted = found[1].source;
  EXPECT_EQ(pasted.at("backend"), "dc1394");
  pasted.erase("backend");
  EXPECT_EQ(refusal(pasted), "no error");
}

TEST_F(IidcCamera, SaysWhichCamerasThereAre) {
  EXPECT_EQ(refusal({{"camera", "0x1"}}), "camera \"0x1\": not found; available: 000a470112345678");
  fake_iidc::clear();
  EXPECT_EQ(refusal(Json::object()),
            "camera \"\": no IIDC camera found; is it plugged in, and may this user open /dev/fw*?");
}

TEST_F(IidcCamera, IsFoundByItsGuidAlsoAfterAnotherCameFirst) {
  fake_iidc::clear();
  fake_iidc::Camera other = fake_iidc::league_camera(kOtherGuid);
  other.format7.clear();
  fake_iidc::plug_in(other);
  fake_iidc::plug_in(fake_iidc::league_camera(kGuid));
  const auto source = open({{"camera", "0x000A470112345678"}});
  EXPECT_EQ(send(kOtherGuid), -1);  // not started
  const int number = send(kGuid);
  expect_scene(next_picture(*source).image.view(), number);
}

TEST_F(IidcCamera, ResetsTheBusOnce) {
  EXPECT_THAT(refusal({{"reset_bus", true}}), HasSubstr("the bus was reset; the camera is reopened"));
  EXPECT_EQ(refusal({{"reset_bus", true}}), "no error");
  EXPECT_EQ(fake_iidc::counts().bus_resets, 1);
}

// ---- losses

TEST_F(IidcCamera, CorruptPicturesAreSkipped) {
  const auto source = open({{"ring_frames", 3}});
  CapturedImage image;
  std::string problem;
  for (int i = 0; i < 10; ++i) {  // more than the ring has, so buffers must be returned to it
    send(kGuid, {.corrupt = true});
    EXPECT_EQ(next(*source, image, problem), CaptureStatus::kIncomplete);
  }
  EXPECT_EQ(problem, "packets are missing");
  const int number = send(kGuid);
  expect_scene(next_picture(*source).image.view(), number);
}

TEST_F(IidcCamera, IsLostWhenUnplugged) {
  const auto source = open();
  fake_iidc::unplug(kGuid);
  CapturedImage image;
  std::string problem;
  EXPECT_EQ(next(*source, image, problem), CaptureStatus::kLost);
  EXPECT_EQ(problem, "camera \"000a470112345678\": no longer delivers: Generic failure");
}

TEST_F(IidcCamera, UnpluggingWakesWhoWaits) {
  const auto source = open();
  std::thread puller([] { fake_iidc::unplug(kGuid); });
  CapturedImage image;
  std::string problem;
  EXPECT_EQ(source->next(image, problem, test::kPatience), CaptureStatus::kLost);
  puller.join();
}

TEST_F(IidcCamera, SilenceIsALossAndSaysWhatTheCameraAnswers) {
  CapturedImage image;
  std::string problem;
  EXPECT_EQ(next(*open({{"silence_s", 3600}}), image, problem), CaptureStatus::kTimeout);
  const auto source = open({{"silence_s", 0.1}});
  EXPECT_EQ(source->next(image, problem, milliseconds(120)), CaptureStatus::kLost);
  EXPECT_EQ(problem,
            "camera \"000a470112345678\": no image for 0.1 s, although it answers (format7_0 yuv422 780x580, "
            "iso_speed 800); do card, cables and hubs support this iso_speed?");
  fake_iidc::stop_by_bus_reset(kGuid);
  EXPECT_EQ(next(*source, image, problem), CaptureStatus::kLost);
  EXPECT_THAT(problem, HasSubstr("it has stopped sending, as after a bus reset"));
}

TEST_F(IidcCamera, WaitingForATriggerIsNoLoss) {
  const auto source = open({{"silence_s", 0.1}, {"controls", {{"trigger_on", true}}}});
  EXPECT_THAT(source->warnings(), IsEmpty());
  CapturedImage image;
  std::string problem;
  EXPECT_EQ(source->next(image, problem, milliseconds(120)), CaptureStatus::kTimeout);
}

TEST_F(IidcCamera, CountsWhatFoundNoBuffer) {
  const auto source = open({{"ring_frames", 4}, {"mode", "640x480_mono8"}, {"frame_rate_hz", 30}});
  const std::uint64_t start_us = 1'700'000'000'000'000, interval_us = 33'333;
  for (std::uint64_t i = 0; i < 10; ++i) send(kGuid, {.timestamp_us = start_us + i * interval_us});
  EXPECT_EQ(fake_iidc::counts().overflows, 6);
  for (int number = 0; number < 4; ++number) expect_scene(next_picture(*source).image.view(), number);
  EXPECT_EQ(source->dropped(), 0U);
  send(kGuid, {.timestamp_us = start_us + 10 * interval_us});
  expect_scene(next_picture(*source).image.view(), 10);
  EXPECT_EQ(source->dropped(), 6U);
}

// ---- times

TEST_F(IidcCamera, TimeIsTheMiddleOfTheExposure) {
  const auto source = open({{"controls", {{"shutter_absolute", 0.010}}}});
  send(kGuid, {.timestamp_us = 1'700'000'000'250'000});
  const CaptureTimes times = next_picture(*source).times;
  // The timestamp is the arrival of the first packet, which is the end of the exposure.
  EXPECT_NEAR(times.t_capture_s, 1'700'000'000.245, 1e-6);
  ASSERT_TRUE(times.t_capture_sigma_s.has_value());
  EXPECT_LT(*times.t_capture_sigma_s, 1e-3);
}

TEST_F(IidcCamera, TimeFollowsTheShutter) {
  const auto source = open({{"controls", {{"shutter_absolute", 0.010}}}});
  source->controls()->set("shutter_absolute", 0.002);
  send(kGuid, {.timestamp_us = 1'700'000'000'250'000});
  EXPECT_NEAR(next_picture(*source).times.t_capture_s, 1'700'000'000.249, 1e-6);
  source->controls()->set("shutter_mode", "auto");
  send(kGuid, {.timestamp_us = 1'700'000'000'250'000});
  const CaptureTimes times = next_picture(*source).times;
  EXPECT_NEAR(times.t_capture_s, 1'700'000'000.250, 1e-6);
  EXPECT_FALSE(times.t_capture_sigma_s.has_value());
}

TEST_F(IidcCamera, OtherDriversStampTheArrival) {
  fake_iidc::Camera camera = fake_iidc::league_camera(kGuid);
  camera.platform = "usb";
  fake_iidc::clear();
  fake_iidc::plug_in(camera);
  const auto source = open({{"controls", {{"shutter_absolute", 0.010}}}});
  send(kGuid, {.timestamp_us = 1'700'000'000'250'000});
  // 780 x 580 x 2 bytes in packets of 6880 bytes, one every 125 us: 132 packets.
  EXPECT_NEAR(next_picture(*source).times.t_capture_s, 1'700'000'000.245 - 132 * 125e-6, 1e-6);
}

// ---- buffers

TEST_F(IidcCamera, NoPictureIsLostUpToTheRingsDepth) {
  const auto source = open({{"ring_frames", 8}});
  std::vector<int> numbers;
  for (int i = 0; i < 8; ++i) numbers.push_back(send(kGuid));
  for (const int number : numbers) expect_scene(next_picture(*source).image.view(), number);
  EXPECT_EQ(source->dropped(), 0U);
  EXPECT_EQ(fake_iidc::counts().overflows, 0);
}

TEST_F(IidcCamera, PicturesMayComeBackInAnyOrder) {
  const auto source = open({{"ring_frames", 5}});
  for (int round = 0; round < 7; ++round) {
    std::vector<int> numbers;
    std::vector<CapturedImage> held;
    for (int i = 0; i < 4; ++i) {
      numbers.push_back(send(kGuid));
      held.push_back(next_picture(*source));
    }
    for (const std::size_t i : {2U, 0U, 3U, 1U}) {
      expect_scene(held[i].image.view(), numbers[i]);
      held[i] = {};
    }
  }
  EXPECT_EQ(fake_iidc::counts().overflows, 0);
}

TEST_F(IidcCamera, PicturesOutliveTheSource) {
  CapturedImage held;
  int number = 0;
  {
    const auto source = open();
    number = send(kGuid);
    held = next_picture(*source);
  }
  EXPECT_FALSE(fake_iidc::state_of(kGuid).sending);
  expect_scene(held.image.view(), number);
  // The camera can be reopened although the old image still holds its share of the bus.
  const auto again = open();
  const int later = send(kGuid);
  expect_scene(next_picture(*again).image.view(), later);
  expect_scene(held.image.view(), number);
  std::thread([image = std::move(held)]() mutable { image = {}; }).join();
  const int last = send(kGuid);
  expect_scene(next_picture(*again).image.view(), last);
}

TEST_F(IidcCamera, PicturesOutliveAnUnpluggedCamera) {
  CapturedImage held;
  int number = 0;
  {
    const auto source = open();
    number = send(kGuid);
    held = next_picture(*source);
    fake_iidc::unplug(kGuid);
  }
  expect_scene(held.image.view(), number);
}

TEST_F(IidcCamera, APictureHeldTooLongCostsPicturesButNoMore) {
  const auto source = open({{"ring_frames", 4}});
  send(kGuid);
  CapturedImage held = next_picture(*source);
  for (int i = 0; i < 3; ++i) {
    send(kGuid);
    next_picture(*source);
  }
  send(kGuid);  // all buffers wait behind the held one
  EXPECT_EQ(fake_iidc::counts().overflows, 1);
  expect_scene(held.image.view(), 0);
  held = {};
  for (int i = 0; i < 8; ++i) {
    const int number = send(kGuid);
    expect_scene(next_picture(*source).image.view(), number);
  }
  EXPECT_EQ(fake_iidc::counts().overflows, 1);
}

int open_files() {
  int count = 0;
  for ([[maybe_unused]] const auto& file : std::filesystem::directory_iterator("/proc/self/fd")) ++count;
  return count;
}
int memory_maps() {
  std::ifstream file("/proc/self/maps");
  return static_cast<int>(std::count(std::istreambuf_iterator<char>(file), {}, '\n'));
}

TEST_F(IidcCamera, UnpluggingLeavesNoFileAndNoMemoryBehind) {
  const auto plug_and_unplug = [] {
    const auto source = open();
    send(kGuid);
    next_picture(*source);
    fake_iidc::unplug(kGuid);
    CapturedImage image;
    std::string problem;
    EXPECT_EQ(next(*source, image, problem), CaptureStatus::kLost);
    fake_iidc::plug_in(fake_iidc::league_camera(kGuid));
  };
  plug_and_unplug();
  const int files = open_files(), maps = memory_maps();
  for (int i = 0; i < 20; ++i) plug_and_unplug();
  EXPECT_EQ(open_files(), files);
  EXPECT_LT(memory_maps(), maps + 10);
}

class IidcAllocations : public IidcFormat {};

TEST_P(IidcAllocations, ThereAreNoneForAPicture) {
  if (!counts_allocations()) GTEST_SKIP() << "the sanitizer has its own allocator";
  const auto source = open({{"pixel_format", GetParam().name}});
  std::string problem;
  for (int i = 0; i < 20; ++i) {
    send(kGuid);
    const std::uint64_t before = allocation_count();
    {
      CapturedImage image;
      ASSERT_EQ(source->next(image, problem, milliseconds(100)), CaptureStatus::kImage);
    }
    ASSERT_EQ(allocation_count(), before) << "picture " << i;
  }
}
INSTANTIATE_TEST_SUITE_P(All, IidcAllocations,
                         testing::Values(Format{"yuv422", {}}, Format{"raw8", {}}, Format{"yuv411", {}},
                                         Format{"mono16", {}}),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST_F(IidcCamera, LendsTheCardsMemoryUncopied) {
  const auto source = open({{"ring_frames", 3}});
  std::vector<const std::uint8_t*> places;
  for (int i = 0; i < 6; ++i) {
    send(kGuid);
    places.push_back(next_picture(*source).image.view().data);
  }
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(places[i], places[i + 3]);
  EXPECT_EQ(places[1] - places[0], 6880 * 132);
}

// ---- on its thread

TEST_F(IidcCamera, ComesBackWithItsSettingsAfterAnUnplug) {
  std::mutex mutex;
  std::condition_variable changed;
  int pictures = 0, width = 0;
  CameraThread camera(
      "camera 0", {},
      [] {
        return open({{"camera", kGuidText},
                     {"width", 400},
                     {"controls", {{"shutter_absolute", 0.003}, {"gain_mode", "manual"}, {"gain", 55}}}});
      },
      [&](CapturedImage&& image) {
        const std::lock_guard lock(mutex);
        ++pictures;
        width = image.image.view().width;
        changed.notify_all();
      },
      {milliseconds(1), milliseconds(5)});
  camera.start();
  const auto see_a_picture = [&](std::uint64_t reconnects) {
    std::unique_lock lock(mutex);
    int before = pictures;
    const auto deadline = std::chrono::steady_clock::now() + test::kPatience;
    while (std::chrono::steady_clock::now() < deadline) {  // until the thread has opened it
      send(kGuid);
      changed.wait_for(lock, milliseconds(5), [&] { return pictures > before; });
      if (camera.health().reconnects < reconnects) {
        before = pictures;
      } else if (pictures > before) {
        return;
      }
    }
    ADD_FAILURE() << "no picture";
  };
  see_a_picture(0);
  fake_iidc::unplug(kGuid);
  fake_iidc::plug_in(fake_iidc::league_camera(kOtherGuid));  // at its old place on the bus
  fake_iidc::plug_in(fake_iidc::league_camera(kGuid));
  see_a_picture(1);
  EXPECT_EQ(width, 400);
  EXPECT_EQ(camera.health().reconnects, 1U);
  EXPECT_THAT(camera.health().warnings, IsEmpty());
  const fake_iidc::Camera now = fake_iidc::state_of(kGuid);
  EXPECT_FLOAT_EQ(now.features.at(DC1394_FEATURE_SHUTTER).absolute_value, 0.003F);
  EXPECT_EQ(now.features.at(DC1394_FEATURE_GAIN).values[0], 55U);
  EXPECT_EQ(now.format7.at(DC1394_VIDEO_MODE_FORMAT7_0).width, 400U);
  EXPECT_FALSE(fake_iidc::state_of(kOtherGuid).sending);
  camera.stop();
}

}  // namespace
}  // namespace sslv
