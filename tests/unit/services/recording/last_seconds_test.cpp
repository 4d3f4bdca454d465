// SPDX-License-Identifier: Apache-2.0
#include "services/recording/last_seconds.h"

#include "config/stages.h"
#include "support/clip_images.h"
#include "support/no_cameras.h"

#include <memory>
#include <vector>

#include <gmock/gmock.h>

namespace sslv::last_seconds_test {
namespace {

class LastSecondsTest : public testing::Test {
 protected:
  LastSecondsTest() {
    setup_.pipeline =
        std::make_shared<Pipeline>(stage_table(), std::vector<std::string>{"segment"}, "/stack");
    for (const int id : {0, 1}) {
      cameras_.recorded_ones[id] = std::make_shared<RecordedCamera>(id, sender_);
      cameras_.recorded_ones[id]->note(setup_, nullptr);
    }
    settings_.memory_mb = 16;
  }
  /// One second, in which camera 0 sends `of_0` images and camera 1 `of_1`.
  void second(int of_0, int of_1) {
    for (int id = 0; id < 2; ++id) {
      for (int i = 0; i < (id == 0 ? of_0 : of_1); ++i) {
        frame_.image = Image(id == 0 ? image_of_0_ : image_.view, nullptr, nullptr, nullptr);
        cameras_.recorded_ones[id]->frame_begins(setup_);
        cameras_.recorded_ones[id]->frame_ends(frame_, setup_);
      }
    }
    last_seconds_.look(recording_, ++now_s_);
  }
  std::vector<double> memory_mb() const {
    std::vector<double> out;
    for (const LastSeconds::CameraStatus& camera : last_seconds_.status().cameras)
      out.push_back(static_cast<double>(camera.bytes) / 1e6);
    return out;
  }

  MulticastSender multicast_{MulticastSettings{}};
  DetectionSender sender_{multicast_};
  CameraSetup setup_;
  OwnedImage image_ = noise_image(PixelFormat::kMono8, 320, 240, 1);
  ImageView image_of_0_ = image_.view;
  Frame frame_;
  test::NoCameras cameras_;
  LastSeconds last_seconds_{cameras_};
  RecordingSettings recording_;
  LastSecondsSettings& settings_ = recording_.last_seconds;
  double now_s_ = 100;
};

TEST_F(LastSecondsTest, MemoryIsSharedByDataRate) {
  for (int i = 0; i < 5; ++i) second(30, 10);
  EXPECT_THAT(memory_mb(), testing::ElementsAre(testing::DoubleNear(12, 0.1), testing::DoubleNear(4, 0.1)));
  for (int i = 0; i < 5; ++i) second(30, 0);
  EXPECT_THAT(memory_mb(), testing::ElementsAre(testing::DoubleNear(12, 0.1), testing::DoubleNear(4, 0.1)))
      << "the last seconds of one that stopped tell why";
}

TEST_F(LastSecondsTest, ASlowerCameraLosesNothing) {
  for (int i = 0; i < 5; ++i) second(30, 30);
  const auto frames = [&](std::size_t camera) { return last_seconds_.status().cameras[camera].frames; };
  const auto before = memory_mb();
  std::uint64_t kept = frames(1);
  for (int i = 0; i < 5; ++i) {
    second(12, 30);
    EXPECT_GE(frames(1), kept);
    kept = frames(1);
  }
  EXPECT_EQ(memory_mb(), before);
  EXPECT_GT(frames(0), 5U * 12);
}

TEST_F(LastSecondsTest, WithoutASizeAClipIsKept) {
  settings_.memory_mb.reset();
  for (int i = 0; i < 5; ++i) second(30, 10);
  constexpr double kImage_mb = 320 * 240e-6, kClip_s = 12;
  EXPECT_THAT(memory_mb(), testing::ElementsAre(testing::DoubleNear(kClip_s * 30 * kImage_mb, 5),
                                                testing::DoubleNear(kClip_s * 10 * kImage_mb, 2)));
  for (int i = 0; i < 12; ++i) second(30, 10);
  EXPECT_GE(last_seconds_.status().cameras[0].frames, kClip_s * 30);
  EXPECT_GE(last_seconds_.status().cameras[1].frames, kClip_s * 10);
  settings_.memory_mb = 0;
  second(30, 10);
  EXPECT_THAT(memory_mb(), testing::ElementsAre(0, 0));
}

TEST_F(LastSecondsTest, ACameraWithAnUnsteadyRateGetsMemory) {
  for (int i = 0; i < 5; ++i) second(i % 2 == 0 ? 5 : 20, 0);
  EXPECT_THAT(memory_mb(), testing::ElementsAre(0, 0)) << "it may only be starting";
  for (int i = 0; i < 4; ++i) second(i % 2 == 0 ? 5 : 20, 0);
  EXPECT_THAT(memory_mb(), testing::ElementsAre(testing::DoubleNear(16, 0.1), 0));
}

TEST_F(LastSecondsTest, ImagesTooLargeForAClipAreReportedAndGetNoMemory) {
  image_of_0_.width = image_of_0_.height = 8192;  // the pixels are never read
  image_of_0_.stride_bytes = 8192;
  for (int i = 0; i < 5; ++i) second(30, 10);
  EXPECT_THAT(memory_mb(), testing::ElementsAre(0, testing::DoubleNear(16, 0.1)));
  EXPECT_EQ(last_seconds_.status().problem,
            "the images of camera 0 are larger than 48 MiB, the most that a clip can hold");
}

}  // namespace
}  // namespace sslv::last_seconds_test
