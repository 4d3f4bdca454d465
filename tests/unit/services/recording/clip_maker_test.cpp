// SPDX-License-Identifier: Apache-2.0
#include "services/recording/clip_maker.h"

#include "base/clock.h"
#include "clips/clip_reader.h"
#include "support/clip_images.h"
#include "support/temporary_folder.h"

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/mman.h>

namespace sslv::clip_maker_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

ClipOrder order_of(const std::string& kind) {
  return {.name = "test", .kind = kind, .why = "a test", .begin_s = 0, .end_s = steady_s()};
}

/// Rings of two cameras, whose frames arrived alternately.
class ClipMakerTest : public testing::Test {
 protected:
  ClipMakerTest() {
    for (std::uint32_t camera = 0; camera < 2; ++camera) {
      rings_.push_back(std::make_shared<ImageRing>(1 << 20));
      rings_.back()->put_setup(0, {static_cast<int>(camera), Json{{"settings", Json::object()}}, {}});
    }
    for (std::uint32_t number = 0; number < 8; ++number) put(number);
  }
  void put(std::uint32_t number) {
    ClipFrame frame;
    frame.info.camera_id = number % 2;
    frame.info.number = number / 2;
    frame.info.times.t_capture_s = 1000 + number;
    frame.info.times.arrived_ns = std::int64_t{number} + 1;
    frame.image = image_.view;
    if (number >= 2 && number < 4) frame.memory = memory_;
    rings_[number % 2]->put(frame);
  }
  std::vector<LastSeconds::Ring> live() const { return {{0, rings_[0]}, {1, rings_[1]}}; }
  std::vector<KeptFile> left(const std::string& name = "last_seconds-") const {
    std::vector<KeptFile> out;
    for (const auto& ring : rings_) {
      out.push_back(
          {name + std::to_string(out.size()) + "-1", OpenFile(::fcntl(ring->fd(), F_DUPFD_CLOEXEC, 0))});
    }
    return out;
  }
  ClipProgress make(std::vector<LastSeconds::Ring> rings, const ClipOrder& order = order_of("kept"),
                    const ClipMaker::Hooks& hooks = {}, const std::stop_token& stop = {}) {
    return ClipMaker(config_, files_, events_).make(order, std::move(rings), 1, hooks, stop);
  }
  /// "camera number" of each frame, in the clip's order.
  std::vector<std::string> frames_of(const ClipProgress& made) const {
    ClipReader clip(files_.path_of(made.file));
    EXPECT_EQ(clip.problem(), "");
    std::vector<std::string> out;
    for (std::size_t i = 0; i < clip.entries().size(); ++i) {
      EXPECT_TRUE(pixels_of(clip.read(i).image) == image_.bytes);
      out.push_back(std::to_string(clip.entries()[i].camera_id) + " " +
                    std::to_string(clip.entries()[i].number));
    }
    return out;
  }
  /// Damages the slot of a frame in camera 0's ring.
  void damage(std::size_t frame) {
    const int fd = rings_[0]->fd();
    void* const memory = ::mmap(nullptr, kRingBlocksAt, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    reinterpret_cast<RingSlot*>(static_cast<std::byte*>(memory) + kRingPage)[frame].begin = ~std::uint64_t{0};
    ::munmap(memory, kRingBlocksAt);
  }

  test::TemporaryFolder folder_;
  RecordingFiles files_{folder_.path()};
  Snapshot<Config> config_{[] {
    Config config;
    config.recording.keep_free_mb = 0;
    return config;
  }()};
  EventQueue events_;
  const OwnedImage image_ = noise_image(PixelFormat::kMono8, 64, 64, 1);
  const std::vector<std::byte> memory_ = std::vector<std::byte>(10);
  std::vector<std::shared_ptr<ImageRing>> rings_;
};

TEST_F(ClipMakerTest, WritesWhatRingsHoldFromWhereStagesCanBegin) {
  std::uint64_t told = 0;
  const ClipProgress made = make(live(), order_of("goal"),
                                 {.tell = [&](const ClipProgress& progress) { told = progress.frames; },
                                  .wait = {},
                                  .happened =
                                      [](double newest_s) {
                                        return std::vector<ClipEvent>{{newest_s, "goal", "1:0"}};
                                      }});
  EXPECT_EQ(made.problem, "");
  EXPECT_THAT(frames_of(made), ElementsAre("0 1", "1 1", "0 2", "1 2", "0 3", "1 3"));
  EXPECT_EQ(told, 6U);
  const ClipReader clip(files_.path_of(made.file));
  EXPECT_EQ(clip.about().kind, "goal") << "the file states its purpose";
  ASSERT_THAT(clip.events(), SizeIs(1));
  EXPECT_EQ(clip.events()[0].time_s, 1007);
  EXPECT_EQ(clip.setup_count(), 2U);
  EXPECT_EQ(clip.setup(1).camera_id, 1);
  rings_[0]->hold(0, steady_ns());
  EXPECT_NE(rings_[0]->oldest_held(), nullptr) << "another clip may have the same frames";
}

TEST_F(ClipMakerTest, WritesTheFramesOfACrash) {
  const ClipProgress made = make(LastSeconds::crash_rings(left()).rings, order_of("crash"));
  EXPECT_EQ(made.problem, "");
  EXPECT_EQ(made.missing, 0U);
  EXPECT_THAT(frames_of(made), ElementsAre("0 1", "1 1", "0 2", "1 2", "0 3", "1 3"));
}

TEST_F(ClipMakerTest, ADamagedFrameIsMissing) {
  damage(2);
  const ClipProgress made = make(LastSeconds::crash_rings(left()).rings);
  EXPECT_THAT(frames_of(made), ElementsAre("0 1", "1 1", "1 2", "0 3", "1 3"));
  EXPECT_EQ(made.missing, 1U);
}

TEST_F(ClipMakerTest, AClipThatCanWaitIsNotWrittenInPart) {
  std::stop_source stop;
  stop.request_stop();
  ClipOrder order = order_of("crash");
  order.can_wait = true;
  Config little = *config_.load();
  little.recording.quota_mb = 1;
  config_.store(little);
  std::ofstream(files_.path_of("old.clip")) << "anything";
  std::filesystem::resize_file(files_.path_of("old.clip"), kMb);
  {
    const LastSeconds::Left once = LastSeconds::crash_rings(left());
    EXPECT_THAT(make(once.rings, order, {}, stop.get_token()).problem, HasSubstr("was stopped"));
    for (const LastSeconds::Ring& ring : once.rings) ring.ring->put_back();
  }
  ASSERT_THAT(files_.list(RecordingFile::Kind::kClip), SizeIs(1)) << "and nothing goes for it";
  EXPECT_THAT(frames_of(make(LastSeconds::crash_rings(left()).rings)), SizeIs(6));
  EXPECT_FALSE(files_.find("old.clip"));
}

TEST_F(ClipMakerTest, AClipThatIsFullIsFinished) {
  ClipMaker maker(config_, files_, events_, kClipEndBlocks + 6);  // including its description and two setups
  const ClipProgress made = maker.make(order_of("kept"), live(), 1, {}, {});
  EXPECT_EQ(made.problem, "");
  EXPECT_THAT(frames_of(made), ElementsAre("0 1", "1 1", "0 2"));
}

TEST_F(ClipMakerTest, AClipWithoutFramesIsDeleted) {
  ClipOrder order = order_of("kept");
  order.begin_s = order.end_s;
  const ClipProgress made = make(live(), order);
  EXPECT_EQ(made.problem, "no camera has images from that time in memory");
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

TEST_F(ClipMakerTest, MemoryIsReadOnceAndOnlyByItsName) {
  for (const char* name : {"", "last_seconds", "last_seconds-x"})
    EXPECT_THAT(LastSeconds::crash_rings(left(name)).rings, IsEmpty()) << name;
  const LastSeconds::Left first = LastSeconds::crash_rings(left());
  EXPECT_THAT(first.rings, SizeIs(2));
  EXPECT_FALSE(first.was_read);
  const LastSeconds::Left second = LastSeconds::crash_rings(left());
  EXPECT_THAT(second.rings, IsEmpty());
  EXPECT_TRUE(second.was_read) << "the service crashed while it read them";
}

}  // namespace
}  // namespace sslv::clip_maker_test
