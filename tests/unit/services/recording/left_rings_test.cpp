// SPDX-License-Identifier: Apache-2.0
#include "services/recording/left_rings.h"

#include "base/clock.h"
#include "clips/clip_reader.h"
#include "clips/image_ring.h"
#include "support/clip_images.h"
#include "support/temporary_folder.h"

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/mman.h>

namespace sslv {
namespace {

/// What a camera's last seconds are like after a crash: a whole image, and parts of three more.
class LeftRingsTest : public testing::Test {
 protected:
  LeftRingsTest() {
    ring_.put_setup(0, {4, Json{{"settings", Json::object()}}, {}});
    for (std::uint32_t number = 0; number < 4; ++number) {
      ClipFrame frame;
      frame.info.camera_id = 4;
      frame.info.number = number;
      frame.info.times.t_capture_s = 1000 + number;
      frame.info.times.arrived_ns = std::int64_t{number} + 1;
      frame.image = image_.view;
      if (number == 0) frame.memory = memory_;
      if (number > 0) frame.tile_px = 32, frame.tiles = tiles_;
      ring_.put(frame);
    }
  }
  std::vector<KeptFile> kept(const std::string& name = "last_seconds-4-1") const {
    std::vector<KeptFile> out;
    out.push_back({name, OpenFile(::fcntl(ring_.fd(), F_DUPFD_CLOEXEC, 0))});
    return out;
  }
  /// The slot of a frame, to damage it.
  RingSlot& slot(std::size_t frame) {
    if (mapped_ == nullptr)
      mapped_ = ::mmap(nullptr, kRingImagesAt, PROT_READ | PROT_WRITE, MAP_SHARED, ring_.fd(), 0);
    return reinterpret_cast<RingSlot*>(static_cast<std::byte*>(mapped_) + kRingPage)[frame];
  }
  ~LeftRingsTest() override {
    if (mapped_ != nullptr) ::munmap(mapped_, kRingImagesAt);
  }
  /// Numbers of the frames of the clip, all of camera 4.
  std::vector<std::uint32_t> written() {
    LeftRings left(kept());
    const test::TemporaryFolder folder;
    {
      ClipWriter writer(folder.file("a.clip"), {});
      while (left.write_next(writer, 1)) {
      }
      writer.finish();
    }
    ClipReader clip(folder.file("a.clip"));
    EXPECT_EQ(clip.problem(), "");
    std::vector<std::uint32_t> out;
    for (const ClipReader::Entry& entry : clip.entries()) {
      EXPECT_EQ(entry.camera_id, 4U);
      out.push_back(entry.number);
    }
    return out;
  }

  OwnedImage image_ = noise_image(PixelFormat::kMono8, 64, 64, 1);
  const std::vector<std::byte> memory_ = std::vector<std::byte>(10), tiles_{std::byte{1}};
  ImageRing ring_{1 << 20};
  void* mapped_ = nullptr;
};

TEST_F(LeftRingsTest, BecomeAClip) {
  EXPECT_THAT(written(), testing::ElementsAre(0, 1, 2, 3));
}

TEST_F(LeftRingsTest, TheCameraIsTheOneTheyWereKeptFor) {
  slot(2).camera_id = 7;
  EXPECT_THAT(written(), testing::ElementsAre(0, 1, 2, 3)) << "what a frame says may be damaged";
}

TEST_F(LeftRingsTest, PartsBehindADamagedFrameAreLeftOut) {
  slot(1).begin = ~std::uint64_t{0};
  EXPECT_THAT(written(), testing::ElementsAre(0)) << "nobody knows what it was";
}

TEST_F(LeftRingsTest, AreThereAgainWhenTheyWerePutBack) {
  {
    LeftRings left(kept());
    EXPECT_EQ(left.extent().frames, 4U);
    left.put_back();
  }
  EXPECT_THAT(written(), testing::ElementsAre(0, 1, 2, 3));
}

TEST_F(LeftRingsTest, TellThatTheServiceCrashedWhileItReadThem) {
  const LeftRings first(kept());
  const LeftRings second(kept());
  EXPECT_FALSE(first.was_read());
  EXPECT_TRUE(second.was_read());
  EXPECT_EQ(second.extent().frames, 0U);
}

TEST_F(LeftRingsTest, OfAnotherNameAreNotLookedAt) {
  for (const char* name : {"last_seconds-", "last_seconds-x-1", "last_seconds-4", "last_seconds--4-1"})
    EXPECT_EQ(LeftRings(kept(name)).extent().frames, 0U) << name;
}

}  // namespace
}  // namespace sslv
