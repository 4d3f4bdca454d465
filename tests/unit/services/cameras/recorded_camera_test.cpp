// SPDX-License-Identifier: Apache-2.0
#include "services/cameras/recorded_camera.h"

#include "config/stages.h"
#include "support/allocation_count.h"
#include "support/clip_images.h"

#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

namespace sslv::recorded_camera_test {
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
  /// Records the next frame, 10 ms later.
  void frame() {
    frame_.info.number = number_++;
    frame_.info.times.arrived_ns = now_ns_ += 10'000'000;
    frame_.image = Image(image_.view, nullptr, nullptr, nullptr);
    recorded_.frame_begins(setup_);
    recorded_.frame_ends(frame_, setup_);
  }
  /// A frame in the ring, and whether it has the stages' memory.
  struct Kept {
    std::uint32_t number;
    bool has_memory;
  };
  std::vector<Kept> kept() {
    std::vector<Kept> out;
    ring_->hold(0, std::numeric_limits<std::int64_t>::max());
    while (const ClipFrame* frame = ring_->oldest_held()) {
      out.push_back({frame->info.number, !frame->memory.empty()});
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

TEST_F(RecordedCameraTest, KeepsEveryFrameAndRegularlyTheStagesMemory) {
  frame();
  keep({});
  for (int i = 0; i < 30; ++i) frame();
  const auto frames = kept();
  ASSERT_EQ(frames.size(), 30U) << "from when it was told to";
  EXPECT_EQ(frames[0].number, 1U);
  for (std::size_t i = 0; i < 30; ++i) EXPECT_EQ(frames[i].has_memory, i % 25 == 0) << "every 250 ms, " << i;
  EXPECT_EQ(recorded_.seen().frames, 31U);
  EXPECT_EQ(recorded_.seen().bytes, 31U * 640 * 480);
}

TEST_F(RecordedCameraTest, KeepsEveryNth) {
  keep({.ring = {}, .every_nth = 4});
  for (int i = 0; i < 12; ++i) frame();
  std::vector<std::uint32_t> numbers;
  for (const Kept& one : kept()) numbers.push_back(one.number);
  EXPECT_THAT(numbers, testing::ElementsAre(0, 4, 8));
}

TEST_F(RecordedCameraTest, ANewPipelineBeginsWithItsStagesMemory) {
  keep({});
  frame();
  setup_.pipeline = std::make_shared<Pipeline>(stage_table(), std::vector<std::string>{"segment"}, "/stack");
  recorded_.note(setup_, nullptr);
  frame();
  EXPECT_TRUE(kept()[1].has_memory);
}

TEST_F(RecordedCameraTest, AllocatesNothingForAFrame) {
  if (!counts_allocations()) GTEST_SKIP() << "allocations are not counted in this build";
  for (const int every_nth : {1, 2}) {
    keep({.ring = {}, .every_nth = every_nth});
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
}  // namespace sslv::recorded_camera_test
