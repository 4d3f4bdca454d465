// SPDX-License-Identifier: Apache-2.0
#include "services/cameras/recorded_camera.h"

#include "clips/clip_format.h"
#include "config/stages.h"
#include "support/allocation_count.h"
#include "support/clip_images.h"
#include "vision/label.h"

#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

namespace sslv {
namespace {

constexpr std::size_t kRing = 64 << 20;

class RecordedCameraTest : public testing::Test {
 protected:
  RecordedCameraTest() {
    setup_.pipeline = std::make_shared<Pipeline>(
        stage_table(), std::vector<std::string>{"segment", "detect_robots", "detect_balls"}, "/stack");
    recorded_.note(setup_, nullptr);
  }
  void keep(RecordedFrames frames) {
    ring_ = std::make_shared<ImageRing>(kRing);
    frames.ring = ring_;
    recorded_.keep(std::move(frames));
  }
  /// A frame in which something orange lies at (x, y), 10 ms after the one before.
  void frame(int x = 100, int y = 100) {
    Frame& frame = frame_;
    frame.info.number = number_++;
    frame.info.times.arrived_ns = now_ns_ += 10'000'000;
    frame.image = Image(image_.view, nullptr, nullptr, nullptr);
    frame.regions.regions = {
        Region{label::kOrange, 40, static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y),
               static_cast<std::uint16_t>(x + 6), static_cast<std::uint16_t>(y + 6), static_cast<float>(x),
               static_cast<float>(y), 0},
        Region{label::kWhite, 40, 0, 0, 639, 3, 320, 1, 0}};
    recorded_.frame_begins(setup_);
    recorded_.frame_ends(frame, setup_);
  }
  /// Of all frames in the ring: the tiles that are marked, and whether it has the stages' memory.
  struct Kept {
    std::uint32_t number;
    bool is_whole, has_memory;
    std::uint64_t pixels;
  };
  std::vector<Kept> kept() {
    std::vector<Kept> out;
    ring_->hold(0, std::numeric_limits<std::int64_t>::max());
    while (const ClipFrame* frame = ring_->oldest_held()) {
      out.push_back(
          {frame->info.number, frame->tile_px == 0, !frame->memory.empty(),
           frame->tile_px == 0 ? 640U * 480U : ClipTiles{640, 480, frame->tile_px}.pixels(frame->tiles)});
      ring_->let_go();
    }
    return out;
  }

  MulticastSender multicast_{MulticastSettings{}};
  DetectionSender sender_{multicast_};
  std::int64_t now_ns_ = 1'000'000'000;
  RecordedCamera recorded_{0, sender_, [this] { return now_ns_; }};
  CameraSetup setup_;
  OwnedImage image_ = noise_image(PixelFormat::kMono8, 640, 480, 1);
  std::shared_ptr<ImageRing> ring_;
  Frame frame_;
  std::uint32_t number_ = 0;
};

TEST_F(RecordedCameraTest, KeepsEveryFrameAndNowAndThenWhatStagesRemember) {
  frame();
  keep({});
  for (int i = 0; i < 30; ++i) frame();
  const auto frames = kept();
  ASSERT_EQ(frames.size(), 30U) << "from when it was told to";
  EXPECT_EQ(frames[0].number, 1U);
  for (std::size_t i = 0; i < 30; ++i) EXPECT_EQ(frames[i].has_memory, i % 25 == 0) << "every 250 ms, " << i;
  for (const Kept& one : frames) EXPECT_TRUE(one.is_whole);
  EXPECT_EQ(recorded_.seen().frames, 31U);
  EXPECT_EQ(recorded_.seen().bytes, 31U * 640 * 480);
}

TEST_F(RecordedCameraTest, KeepsEveryNth) {
  keep({.ring = {}, .images = RecordedFrames::Images::kEveryNth, .every_nth = 4});
  for (int i = 0; i < 12; ++i) frame();
  std::vector<std::uint32_t> numbers;
  for (const Kept& one : kept()) numbers.push_back(one.number);
  EXPECT_THAT(numbers, testing::ElementsAre(0, 4, 8));
}

TEST_F(RecordedCameraTest, KeepsThePartsWhereColoursAreAndWhereTheyWereInTheWholeImage) {
  keep({.ring = {}, .images = RecordedFrames::Images::kFound});
  frame(100, 100);  // tiles (2..3, 2..3), with what is around
  frame(500, 310);
  frame(100, 100);
  const auto frames = kept();
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_TRUE(frames[0].is_whole);
  EXPECT_FALSE(frames[1].is_whole);
  EXPECT_EQ(frames[2].pixels, 4U * 32 * 32) << "lines are no parts";
  EXPECT_EQ(frames[1].pixels, 2 * frames[2].pixels) << "what has gone must not seem to be there";
}

TEST_F(RecordedCameraTest, ANewPipelineBeginsWithWhatItRemembers) {
  keep({});
  frame();
  setup_.pipeline = std::make_shared<Pipeline>(stage_table(), std::vector<std::string>{"segment"}, "/stack");
  recorded_.note(setup_, nullptr);
  frame();
  EXPECT_TRUE(kept()[1].has_memory);
}

TEST_F(RecordedCameraTest, AllocatesNothingForAFrame) {
  if (!counts_allocations()) GTEST_SKIP() << "allocations are not counted in this build";
  for (const auto images :
       {RecordedFrames::Images::kWhole, RecordedFrames::Images::kEveryNth, RecordedFrames::Images::kFound}) {
    keep({.ring = {}, .images = images, .every_nth = 2});
    frame();
    const std::uint64_t before = allocation_count();
    for (int i = 0; i < 100; ++i) {
      recorded_.frame_begins(setup_);
      recorded_.frame_ends(frame_, setup_);
    }
    EXPECT_EQ(allocation_count() - before, 0U);
  }
}

}  // namespace
}  // namespace sslv
