// SPDX-License-Identifier: Apache-2.0
//
// The memory of an ImageRing that the next process inherits from a crashed one.
#include "clips/clip_format.h"
#include "clips/image_ring.h"
#include "support/clip_images.h"

#include <csignal>
#include <cstddef>
#include <functional>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

namespace sslv::crash_ring_test {
namespace {

using ::testing::HasSubstr;

constexpr std::size_t kLeftBytes = 1 << 20;

ClipFrame left_frame(std::uint32_t number, const ImageView& image) {
  ClipFrame frame;
  frame.info.camera_id = 3;
  frame.info.number = number;
  frame.info.times.t_capture_s = 1000 + number;
  frame.info.times.t_capture_sigma_s = .002;
  frame.info.times.arrived_ns = std::int64_t{number} + 1;
  frame.setup = number / 10;
  frame.image = image;
  return frame;
}

OwnedImage left_image(std::uint32_t number) {
  return noise_image(PixelFormat::kUyvy, 128, 64, number);
}

ClipSetup left_setup(std::uint32_t number) {
  return {3, Json{{"settings", {{"number", number}}}}, std::vector<std::byte>(1000, std::byte(number))};
}

void fill(ImageRing& ring, std::uint32_t frames = 100) {
  for (std::uint32_t number = 0; number < frames; ++number) {
    if (number % 10 == 0) ring.put_setup(number / 10, left_setup(number / 10));
    const OwnedImage image = left_image(number);
    ring.put(left_frame(number, image.view));
  }
}

OpenFile another(const ImageRing& ring) {
  return OpenFile(::fcntl(ring.fd(), F_DUPFD_CLOEXEC, 0));
}

/// Ring memory left by a process that ran `process` and was killed.
OpenFile left_by(const std::function<void(ImageRing&)>& process) {
  ImageRing ring(kLeftBytes);
  const pid_t child = ::fork();
  if (child == 0) {
    process(ring);
    ::kill(::getpid(), SIGKILL);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFSIGNALED(status));
  // A copy, since the ring's destructor frees its memory here.
  const OpenFile from = another(ring);
  const auto size = static_cast<std::size_t>(ring_file_bytes(ring.bytes()));
  OpenFile out(::memfd_create("test", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  EXPECT_EQ(::ftruncate(out.fd(), static_cast<off_t>(size)), 0);
  EXPECT_EQ(::fcntl(out.fd(), F_ADD_SEALS, F_SEAL_SHRINK), 0);
  std::vector<std::byte> part(1 << 16);
  for (off_t at = 0; (at = ::lseek(from.fd(), at, SEEK_DATA)) >= 0;) {
    const ssize_t got = ::pread(from.fd(), part.data(), part.size(), at);
    EXPECT_EQ(::pwrite(out.fd(), part.data(), static_cast<std::size_t>(got), at), got);
    at += got;
  }
  return out;
}

void hold_all(ImageRing& ring) {
  ring.hold(0, std::numeric_limits<std::int64_t>::max());
}

/// Reads all frames. Returns their number.
std::size_t read_all(ImageRing& ring) {
  std::size_t frames = 0;
  unsigned seen = 0;
  hold_all(ring);
  while (const ClipFrame* frame = ring.oldest_held()) {
    ++frames;
    EXPECT_TRUE(frame->image.empty() ||
                is_valid_size(frame->image.format, frame->image.width, frame->image.height));
    for (const std::uint8_t pixel : pixels_of(frame->image)) seen += pixel;
    for (const auto part : {frame->packet, frame->memory})
      for (const std::byte byte : part) seen += std::to_integer<unsigned>(byte);
    seen += static_cast<unsigned>(ring.setup(frame->setup).size());
    ring.let_go();
  }
  EXPECT_NE(seen, 1U);
  return frames;
}

std::string why_not_read(OpenFile file) {
  try {
    const ImageRing ring(std::move(file));
  } catch (const ClipError& error) {
    return error.what();
  }
  return "";
}

TEST(CrashRing, HasTheFramesOfAKilledProcess) {
  ImageRing ring(left_by([](ImageRing& one) { fill(one, 200); }));
  const ImageRing::Extent extent = ring.extent();
  EXPECT_GT(extent.frames, 50U);
  EXPECT_LT(extent.frames, 150U) << "the ring was full";
  EXPECT_EQ(extent.newest_ns, 200);
  const auto first = static_cast<std::uint32_t>(200 - extent.frames);
  EXPECT_EQ(extent.oldest_ns, first + 1);
  hold_all(ring);
  EXPECT_GT(ring.held_bytes(), kLeftBytes / 2);
  for (std::uint32_t number = first; number < 200; ++number) {
    const ClipFrame* frame = ring.oldest_held();
    ASSERT_NE(frame, nullptr);
    EXPECT_EQ(frame->info.number, number);
    EXPECT_EQ(frame->info.camera_id, 3U);
    EXPECT_EQ(frame->info.times.t_capture_s, 1000 + number);
    EXPECT_EQ(frame->info.times.t_capture_sigma_s, .002);
    EXPECT_EQ(frame->info.times.arrived_ns, number + 1);
    EXPECT_EQ(pixels_of(frame->image), pixels_of(left_image(number).view));
    const auto payload = ring.setup(frame->setup);
    const auto parts = setup_in(payload);
    ASSERT_TRUE(parts);
    const ClipSetup setup = left_setup(number / 10);
    EXPECT_EQ(std::string(reinterpret_cast<const char*>(parts->json.data()), parts->json.size()),
              setup.about.dump());
    EXPECT_TRUE(std::ranges::equal(parts->table, setup.table));
    ring.let_go();
  }
  EXPECT_EQ(ring.oldest_held(), nullptr);
  EXPECT_TRUE(ring.setup(20).empty()) << "no frame had it";
}

TEST(CrashRing, HasFramesHeldAtTheEndOfTheProcess) {
  ImageRing ring(left_by([](ImageRing& one) {
    fill(one);
    hold_all(one);
  }));
  EXPECT_EQ(read_all(ring), ring.extent().frames);
}

TEST(CrashRing, IsEmptyWhenTheProcessEndedWell) {
  OpenFile file;
  {
    ImageRing ring(kLeftBytes);
    fill(ring);
    file = another(ring);
  }
  struct stat about {};
  ASSERT_EQ(::fstat(file.fd(), &about), 0);
  EXPECT_EQ(about.st_blocks, 0) << "its memory was given back, though the file is open";
  EXPECT_THAT(why_not_read(std::move(file)), HasSubstr("ended normally"));
}

TEST(CrashRing, IsReadOnce) {
  ImageRing ring(kLeftBytes);
  fill(ring);
  OpenFile again = another(ring), stays = another(ring);
  {
    const ImageRing left(another(ring));
    EXPECT_GT(left.extent().frames, 0U);
    EXPECT_THAT(why_not_read(std::move(again)), HasSubstr("that read it crashed"))
        << "as after a crash in between";
  }
  struct stat about {};
  ASSERT_EQ(::fstat(stays.fd(), &about), 0);
  EXPECT_EQ(about.st_blocks, 0);
}

TEST(CrashRing, IsThereAgainWhenItWasPutBack) {
  ImageRing ring(kLeftBytes);
  fill(ring);
  {
    ImageRing left(another(ring));
    hold_all(left);
    left.let_go();
    left.put_back();
  }
  ImageRing again(another(ring));
  EXPECT_EQ(read_all(again), again.extent().frames);
}

TEST(CrashRing, RefusesInvalidMemory) {
  EXPECT_THAT(why_not_read(OpenFile(::open("/dev/null", O_RDWR))), HasSubstr("not an image ring"));
  OpenFile small(::memfd_create("test", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  EXPECT_THAT(why_not_read(OpenFile(::dup(small.fd()))), HasSubstr("not an image ring")) << "it may shrink";
  ASSERT_EQ(::fcntl(small.fd(), F_ADD_SEALS, F_SEAL_SHRINK), 0);
  EXPECT_THAT(why_not_read(std::move(small)), HasSubstr("too small"));

  const auto with = [](std::size_t place, std::uint64_t value) {
    OpenFile file = left_by([](ImageRing& one) { fill(one); });
    EXPECT_EQ(::pwrite(file.fd(), &value, sizeof value, static_cast<off_t>(place)), 8);
    return why_not_read(std::move(file));
  };
  EXPECT_THAT(with(4, 0), HasSubstr("another version"));
  for (const std::uint64_t bytes : {std::uint64_t{0}, std::uint64_t{64}, std::uint64_t{kLeftBytes} * 2,
                                    ~std::uint64_t{0}, ~std::uint64_t{63}})
    EXPECT_THAT(with(offsetof(RingHead, room), bytes), HasSubstr("its size")) << bytes;
}

TEST(CrashRing, SetupsThatNoFrameNeedsTakeNoMemory) {
  ImageRing ring(kLeftBytes);
  const auto blocks = [&] {
    struct stat about {};
    ::fstat(ring.fd(), &about);
    return about.st_blocks;
  };
  const auto before = blocks();
  for (std::uint32_t number = 0; number < 1000; ++number) {
    ring.put_setup(number, left_setup(number));
    ASSERT_LE(blocks() - before, static_cast<long>(kRingSetups * kRingPage / 512));
  }
  ring.forget_setups_before(1000);
  EXPECT_EQ(blocks(), before);
}

/// Ring memory that its process corrupted.
class DamagedCrashRing : public testing::Test {
 protected:
  static std::size_t frames_with(const std::function<void(std::byte* memory, std::size_t bytes)>& damage) {
    OpenFile file = left_by([](ImageRing& one) { fill(one); });
    const std::size_t bytes = ring_mapped_bytes(kLeftBytes);
    void* const memory = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file.fd(), 0);
    damage(static_cast<std::byte*>(memory), bytes);
    ::munmap(memory, bytes);
    try {
      ImageRing ring(std::move(file));
      return read_all(ring);
    } catch (const ClipError&) {
      return 0;
    }
  }
};

TEST_F(DamagedCrashRing, GivesWhatIsStillGood) {
  const std::size_t all = frames_with([](std::byte*, std::size_t) {});
  EXPECT_GT(all, 20U);
  std::minstd_rand chance(7);
  for (int round = 0; round < 60; ++round) {
    const std::size_t frames = frames_with([&](std::byte* memory, std::size_t bytes) {
      // Flips bits anywhere, in the slots or in the head.
      const std::size_t within = round % 3 == 0 ? bytes : round % 3 == 1 ? kRingBlocksAt / 32 : 64;
      for (int i = 0; i < 1 + round; ++i)
        memory[16 + chance() % (within - 16)] ^= std::byte{1} << chance() % 8;
    });
    EXPECT_LE(frames, kRingSlots);
  }
}

TEST_F(DamagedCrashRing, SurvivesNoise) {
  std::minstd_rand chance(8);
  for (int round = 0; round < 20; ++round) {
    frames_with([&](std::byte* memory, std::size_t bytes) {
      // Overwrites all frames, all slots, or the frame numbers in the head.
      const std::size_t from = round % 3 == 0   ? kRingBlocksAt
                               : round % 3 == 1 ? kRingPage
                                                : offsetof(RingHead, begin);
      const std::size_t to = round % 3 == 0 ? bytes : round % 3 == 1 ? kRingBlocksAt : kRingPage;
      for (std::size_t at = from; at < to; ++at) memory[at] = std::byte(chance());
    });
  }
}

TEST_F(DamagedCrashRing, SlotsThatPointElsewhereGiveNoFrame) {
  for (const std::uint64_t value : {std::uint64_t{0}, std::uint64_t{kLeftBytes} - 64, ~std::uint64_t{0},
                                    ~std::uint64_t{0} - 200, std::uint64_t{1} << 63U}) {
    for (std::uint64_t RingSlot::*field : {&RingSlot::begin, &RingSlot::bytes}) {
      frames_with([&](std::byte* memory, std::size_t) {
        auto* const slots = reinterpret_cast<RingSlot*>(memory + kRingPage);
        for (std::size_t i = 0; i < 100; ++i) slots[i].*field = value;
      });
    }
  }
}

TEST(CrashRing, DropsDamagedSetups) {
  const std::size_t end =
      kClipBlockBytes + kClipSetupBytes + left_setup(1).about.dump().size() + left_setup(1).table.size();
  for (std::size_t at = 0; at < end + 100; ++at) {
    ImageRing ring(kLeftBytes);
    ring.put_setup(1, left_setup(1));
    const auto place = static_cast<off_t>(ring_setup_place(ring.bytes(), 1) + at);
    std::uint8_t byte = 0;
    ASSERT_EQ(::pread(ring.fd(), &byte, 1, place), 1);
    byte ^= static_cast<std::uint8_t>(1U << at % 8);
    ASSERT_EQ(::pwrite(ring.fd(), &byte, 1, place), 1);
    const ImageRing left(another(ring));
    EXPECT_EQ(left.setup(1).empty(), at < end) << at;
  }
}

}  // namespace
}  // namespace sslv::crash_ring_test
