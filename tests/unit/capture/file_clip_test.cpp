// SPDX-License-Identifier: Apache-2.0
#include "base/error.h"
#include "capture/files/file.h"
#include "capture/files/file_playback.h"
#include "clips/clip_writer.h"
#include "support/clip_images.h"
#include "support/patience.h"
#include "support/temporary_folder.h"

#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <vector>

#include <gmock/gmock.h>

namespace sslv::file_clip_test {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A clip of two cameras with 5 frames each. Camera 3 has images of 12 bits, camera 5 parts of larger images.
class ClipSource : public testing::Test {
 protected:
  ClipSource() {
    ClipWriter writer(path("kick.clip"), {});
    writer.add(ClipSetup{});
    for (unsigned i = 0; i < 5; ++i) {
      for (const std::uint32_t camera_id : {3U, 5U}) {
        images_[camera_id == 3 ? 0 : 1][i] =
            noise_image(camera_id == 3 ? PixelFormat::kBayerGr8 : PixelFormat::kUyvy, 12, 8, i + camera_id, 4,
                        camera_id == 3);
        ClipFrame frame;
        frame.info.camera_id = camera_id;
        frame.info.number = 500 + i;
        frame.info.times.t_capture_s = 1e9 + kTimes_s[i];
        if (camera_id == 5) frame.info.times.t_capture_camera_s = 77 + i;
        if (camera_id == 5) frame.info.whole = {.width = 24, .height = 16, .x = 12, .y = 8};
        frame.image = images_[camera_id == 3 ? 0 : 1][i].view;
        writer.add(frame);
        places_.push_back(writer.bytes());
      }
    }
    writer.finish();
  }

  std::string path(const std::string& name) const { return folder_.file(name); }
  std::unique_ptr<Source> open(const std::string& what, Json options = Json::object()) const {
    options["path"] = path(what);
    return file_backend().open(file_backend().complete(options, ""), {});
  }
  std::string refusal(const std::string& what, const Json& options = Json::object()) const {
    try {
      open(what, options);
    } catch (const CaptureError& error) {
      return error.what();
    }
    return "no error";
  }
  /// Changes one byte of the file.
  void damage(std::uint64_t place) const {
    std::fstream file(path("kick.clip"), std::ios::binary | std::ios::in | std::ios::out);
    file.seekg(static_cast<std::streamoff>(place));
    const int old = file.get();
    file.seekp(static_cast<std::streamoff>(place));
    file.put(static_cast<char>(old ^ 1));
  }

  static constexpr std::array kTimes_s{0.0, 0.01, 0.02, 0.5, 0.51};
  test::TemporaryFolder folder_;
  std::array<std::array<OwnedImage, 5>, 2> images_;
  std::vector<std::uint64_t> places_;  // ends of the frames' blocks
};

struct Got {
  CaptureStatus status = CaptureStatus::kEnd;
  CapturedImage image;
  std::string problem;
};
Got next_of(Source& source, milliseconds timeout = milliseconds(0)) {
  Got out;
  out.status = source.next(out.image, out.problem, timeout);
  return out;
}

TEST_F(ClipSource, GivesTheFramesOfACameraAsTheyWere) {
  for (const int camera : {3, 5}) {
    const auto source = open("kick.clip", {{"camera_id", camera}, {"frame_rate_hz", 0}});
    const double now_s =
        std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
    for (unsigned i = 0; i < 5; ++i) {
      const Got got = next_of(*source);
      ASSERT_EQ(got.status, CaptureStatus::kImage) << got.problem;
      const OwnedImage& image = images_[camera == 3 ? 0 : 1][i];
      EXPECT_EQ(got.image.image.view().format, image.view.format);
      EXPECT_EQ(got.image.image.view().to_low_bits != 0, camera == 3);
      EXPECT_TRUE(pixels_of(got.image.image.view()) == pixels_of(image.view));
      EXPECT_EQ(got.image.whole.x, camera == 5 ? 12 : 0);
      EXPECT_EQ(got.image.name, "kick00050" + std::to_string(i));
      EXPECT_NEAR(got.image.times.t_capture_s, now_s, test::kPatience.count())
          << "live consumers get no old times";
      EXPECT_EQ(got.image.times.t_capture_camera_s, camera == 5 ? 77 + i : 1e9 + kTimes_s[i]);
    }
    EXPECT_EQ(next_of(*source).status, CaptureStatus::kEnd);
  }
  // Without camera_id, the first camera is used.
  const auto source = open("kick.clip");
  EXPECT_EQ(next_of(*source).image.image.view().format, PixelFormat::kBayerGr8);
}

TEST_F(ClipSource, KeepsTheTimesBetweenFrames) {
  std::vector<double> times_s;
  const auto begin = std::chrono::steady_clock::now();
  const auto source = open("kick.clip");
  for (int i = 0; i < 5; ++i) {
    ASSERT_EQ(next_of(*source, test::kPatience).status, CaptureStatus::kImage);
    times_s.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  // Never too early; delays depend on the computer.
  for (std::size_t i = 1; i < 5; ++i) EXPECT_GE(times_s[i], kTimes_s[i] - 0.002) << i;
  EXPECT_EQ(next_of(*source, test::kPatience).status, CaptureStatus::kEnd);
}

TEST_F(ClipSource, ItsControlsAreThoseOfAPlayer) {
  const auto source = open("kick.clip", {{"camera_id", 3}, {"loop", true}, {"controls", {{"speed", 16.0}}}});
  EXPECT_TRUE(source->warnings().empty());
  const auto controls = source->controls();
  EXPECT_EQ(controls->get("speed").value, 16.0);
  EXPECT_EQ(controls->get("position").most, 4);
  controls->set("paused", true);
  EXPECT_EQ(next_of(*source).status, CaptureStatus::kTimeout);
  for (const int i : {4, 0, 2}) {
    controls->set("position", i);
    EXPECT_EQ(next_of(*source).image.name, "kick00050" + std::to_string(i));
  }
  controls->set("step", nullptr);
  EXPECT_EQ(next_of(*source).image.name, "kick000503");
  controls->set("step_back", nullptr);
  EXPECT_EQ(next_of(*source).image.name, "kick000502");
  controls->set("paused", false);
  for (const int i : {3, 4, 0, 1})
    EXPECT_EQ(next_of(*source, test::kPatience).image.name, "kick00050" + std::to_string(i));
}

TEST_F(ClipSource, ARateOfItsOwnCounts) {
  const auto source = open("kick.clip", {{"frame_rate_hz", 0.001}});
  EXPECT_EQ(next_of(*source).status, CaptureStatus::kImage);
  EXPECT_EQ(next_of(*source).status, CaptureStatus::kTimeout);
}

TEST_F(ClipSource, DamagedFramesAreNamedAndSkipped) {
  damage(places_[1] - 20);  // in the pixels of camera 5's first frame
  const auto source = open("kick.clip", {{"camera_id", 5}, {"frame_rate_hz", 0}});
  const Got bad = next_of(*source);
  EXPECT_EQ(bad.status, CaptureStatus::kIncomplete);
  EXPECT_EQ(bad.problem, path("kick.clip") + ": frame 500 of camera 5 is damaged");
  EXPECT_EQ(next_of(*source).image.name, "kick000501");
}

TEST_F(ClipSource, GoesOnWhenItsFileIsRemoved) {
  const auto source = open("kick.clip", {{"loop", true}, {"frame_rate_hz", 0}});
  next_of(*source);
  fs::remove(path("kick.clip"));
  for (int i = 0; i < 50; ++i) EXPECT_EQ(next_of(*source).status, CaptureStatus::kImage);
}

TEST_F(ClipSource, AnUnfinishedClipIsPlayedToItsEnd) {
  fs::resize_file(path("kick.clip"), places_[4]);  // three frames of camera 3
  const auto source = open("kick.clip", {{"frame_rate_hz", 0}});
  for (int i = 0; i < 3; ++i) EXPECT_EQ(next_of(*source).status, CaptureStatus::kImage);
  EXPECT_EQ(next_of(*source).status, CaptureStatus::kEnd);
}

TEST_F(ClipSource, UnplayableClipsAreNamed) {
  EXPECT_EQ(refusal("kick.clip", {{"camera_id", 4}}),
            path("kick.clip") + ": no camera 4 in this clip; expected 3, 5");
  std::ofstream(path("text.clip")) << "this is no clip, but a text";
  EXPECT_EQ(refusal("text.clip"),
            path("text.clip") + ": is not a clip: it does not start with the clip signature");
  { ClipWriter(path("none.clip"), {}).finish(); }
  EXPECT_EQ(refusal("none.clip"), path("none.clip") + ": no frames in this clip");
  EXPECT_THAT(refusal("nowhere.clip"), HasSubstr("No such file or directory; expected"));
  std::ofstream(path("a.raw")) << "12345678";
  EXPECT_THAT(refusal("a.raw", {{"camera_id", 3}, {"pixel_format", "mono8"}, {"width", 4}, {"height", 2}}),
              HasSubstr("only a clip (.clip) has cameras"));
  // Clips in a folder of images are skipped.
  const auto source =
      open("", {{"pixel_format", "mono8"}, {"width", 4}, {"height", 2}, {"frame_rate_hz", 0}});
  EXPECT_EQ(next_of(*source).image.name, "a");
  EXPECT_EQ(next_of(*source).status, CaptureStatus::kEnd);
}

TEST(PlaybackByTimes, InvalidTimesDoNotBlock) {
  Playback playback({1e300, -5, std::nan(""), 0}, true);
  EXPECT_EQ(playback.wait_turn(milliseconds(0)), 0);
  EXPECT_FALSE(playback.wait_turn(milliseconds(1)));
  playback.set("speed", 100.0);
  EXPECT_EQ(playback.wait_turn(milliseconds(0)), 1);  // because a control was set
  EXPECT_EQ(playback.wait_turn(milliseconds(0)), 2);
}

}  // namespace
}  // namespace sslv::file_clip_test
