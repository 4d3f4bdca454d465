// SPDX-License-Identifier: Apache-2.0
#include "clips/image_ring.h"

#include "clips/clip_format.h"
#include "support/allocation_count.h"
#include "support/clip_images.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <unistd.h>

namespace sslv::image_ring_test {
namespace {

constexpr std::size_t kRingBytes = 1 << 20;

std::vector<std::byte> bytes_of(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

/// A frame that arrives at `number` milliseconds.
ClipFrame numbered(std::uint32_t number, const ImageView& image) {
  ClipFrame frame;
  frame.info.camera_id = 3;
  frame.info.number = number;
  frame.info.times.arrived_ns = std::int64_t{number} * 1'000'000;
  frame.setup = number / 10;
  frame.image = image;
  return frame;
}

std::vector<std::uint32_t> held_numbers(ImageRing& ring) {
  std::vector<std::uint32_t> out;
  while (const ClipFrame* frame = ring.oldest_held()) {
    out.push_back(frame->info.number);
    ring.let_go();
  }
  return out;
}

TEST(ImageRing, GivesBackAllOfAFrame) {
  ImageRing ring(kRingBytes);
  const auto packet = bytes_of("packet"), memory = bytes_of("memory of stages");
  for (const bool is_deep : {false, true}) {
    const OwnedImage image = noise_image(PixelFormat::kBayerGb8, 62, 40, 7, 3, is_deep);
    ClipFrame frame = numbered(is_deep ? 2 : 1, image.view);
    frame.info.times.t_capture_s = 12.5;
    frame.info.whole = {100, 90, 4, 6};
    frame.packet = packet;
    frame.memory = memory;
    ASSERT_TRUE(ring.put(frame));
    ring.hold(0, 10'000'000'000);
    const ClipFrame* got = ring.oldest_held();
    ASSERT_NE(got, nullptr);
    EXPECT_EQ(got->info.number, frame.info.number);
    EXPECT_EQ(got->info.times.t_capture_s, 12.5);
    EXPECT_EQ(got->info.whole.x, 4);
    EXPECT_EQ(got->image.format, PixelFormat::kBayerGb8);
    EXPECT_EQ(pixels_of(got->image), pixels_of(image.view));
    EXPECT_TRUE(std::ranges::equal(got->packet, packet));
    EXPECT_TRUE(std::ranges::equal(got->memory, memory));
    ring.let_go();
    EXPECT_EQ(ring.oldest_held(), nullptr);
  }
}

// Large images are copied with non-temporal stores; the second plane of a deep one may begin in the middle of
// a cache line.
TEST(ImageRing, GivesBackLargeImagesOfAnySize) {
  ImageRing ring(kRingBytes);
  for (const int width : {640, 641, 703}) {
    for (const bool is_deep : {false, true}) {
      const OwnedImage image =
          noise_image(PixelFormat::kMono8, width, 301, static_cast<unsigned>(width), 0, is_deep);
      ASSERT_TRUE(ring.put(numbered(1, image.view)));
      ring.hold(0, 10'000'000'000);
      const ClipFrame* got = ring.oldest_held();
      ASSERT_NE(got, nullptr);
      EXPECT_EQ(pixels_of(got->image), pixels_of(image.view)) << width << (is_deep ? " deep" : "");
      ring.let_go();
    }
  }
}

TEST(ImageRing, DropsNonFiniteOptionalTimes) {
  ImageRing ring(kRingBytes);
  const OwnedImage image = noise_image(PixelFormat::kMono8, 64, 32, 1);
  ClipFrame frame = numbered(1, image.view);
  frame.info.times.t_capture_sigma_s = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(ring.put(frame));
  ring.hold(0, 10'000'000'000);
  ASSERT_NE(ring.oldest_held(), nullptr);
  EXPECT_FALSE(ring.oldest_held()->info.times.t_capture_sigma_s);
  frame.info.times.t_capture_s = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(ring.put(frame)) << "no clip could hold it";
  EXPECT_EQ(ring.extent().dropped, 1U);
}

TEST(ImageRing, ASlotHoldsTheBlockOfAClip) {
  ImageRing ring(kRingBytes);
  const OwnedImage image = noise_image(PixelFormat::kUyvy, 70, 50, 1, 6);
  const auto packet = bytes_of("sent");
  ClipFrame frame = numbered(5, image.view);
  frame.packet = packet;
  ASSERT_TRUE(ring.put(frame));
  std::vector<std::byte> memory(ring_mapped_bytes(ring.bytes()));
  ASSERT_EQ(::pread(ring.fd(), memory.data(), memory.size(), 0), static_cast<ssize_t>(memory.size()));
  const auto& slot = *reinterpret_cast<const RingSlot*>(memory.data() + kRingPage);
  const auto block = std::span(memory).subspan(kRingBlocksAt + slot.begin, slot.bytes);
  const auto head = block_head_of(block.first<kClipBlockBytes>());
  ASSERT_TRUE(head);
  EXPECT_EQ(head->type, static_cast<std::uint32_t>(ClipBlock::kFrame));
  EXPECT_EQ(head->camera_id, 3U);
  EXPECT_EQ(head->bytes, kClipFrameBytes + 4 + 2 * 70 * 50);
  const auto frame_head = frame_head_of(block.subspan(kClipBlockBytes).first<kClipFrameBytes>(), head->bytes);
  ASSERT_TRUE(frame_head);
  EXPECT_EQ(frame_head->info.number, 5U);
  EXPECT_EQ(frame_head->image_bytes, 2U * 70 * 50);
}

TEST(ImageRing, ReportsHeldBytesAndSetups) {
  ImageRing ring(kRingBytes);
  const OwnedImage image = noise_image(PixelFormat::kMono8, 100, 100, 1);
  for (std::uint32_t number = 1; number <= 5; ++number) ASSERT_TRUE(ring.put(numbered(number, image.view)));
  EXPECT_EQ(ring.held_bytes(), 0U);
  ring.hold(2'000'000, 4'000'000);
  EXPECT_EQ(ring.held_bytes(), 3U * (kClipBlockBytes + kClipFrameBytes + 10'000));
  ring.put_setup(7, {.camera_id = 3, .about = {{"a", 1}}, .table = bytes_of("table")});
  const auto payload = ring.setup(7);
  const auto parts = setup_in(payload);
  ASSERT_TRUE(parts);
  EXPECT_EQ(parts->number, 7U);
  EXPECT_TRUE(std::ranges::equal(parts->json, bytes_of(R"({"a":1})")));
  EXPECT_TRUE(std::ranges::equal(parts->table, bytes_of("table")));
  EXPECT_TRUE(ring.setup(8).empty());
  EXPECT_TRUE(ring.setup(7 + kRingSetups).empty()) << "its place has another's";
  ring.forget_setups_before(8);
  EXPECT_TRUE(ring.setup(7).empty());
  EXPECT_THROW(ring.put_setup(9, {.table = std::vector<std::byte>(kMaxClipTableBytes + 1)}), ClipError);
}

TEST(ImageRing, TheOldestMakeRoom) {
  ImageRing ring(kRingBytes);
  std::uint32_t number = 0;
  for (; number < 500; ++number) {
    // Sizes differ, so that frames do not always begin at the same places.
    const OwnedImage image =
        noise_image(PixelFormat::kMono8, 100 + static_cast<int>(number % 7) * 20, 100, number);
    ASSERT_TRUE(ring.put(numbered(number, image.view)));
    const ImageRing::Extent extent = ring.extent();
    EXPECT_EQ(extent.newest_ns, std::int64_t{number} * 1'000'000);
    EXPECT_EQ(extent.newest_ns - extent.oldest_ns, static_cast<std::int64_t>(extent.frames - 1) * 1'000'000);
    EXPECT_EQ(extent.oldest_setup, extent.oldest_ns / 10'000'000);
  }
  EXPECT_GT(ring.extent().frames, 50U);
  EXPECT_LT(ring.extent().frames, 100U);
  EXPECT_EQ(ring.extent().dropped, 0U);
  ring.hold(0, 10'000'000'000);
  const auto kept = held_numbers(ring);
  EXPECT_EQ(kept.back(), 499U);
  for (std::size_t i = 1; i < kept.size(); ++i) EXPECT_EQ(kept[i], kept[i - 1] + 1);
}

TEST(ImageRing, HeldFramesStayUntilReleased) {
  ImageRing ring(kRingBytes);
  const OwnedImage image = noise_image(PixelFormat::kMono8, 256, 256, 1);
  for (std::uint32_t number = 0; number < 10; ++number) ASSERT_TRUE(ring.put(numbered(number, image.view)));
  ring.hold(4'000'000, 6'000'000);
  // The ring accepts frames until it reaches the held ones.
  std::uint32_t number = 10;
  while (ring.put(numbered(number, image.view))) ++number;
  EXPECT_GT(number, 10U);
  EXPECT_EQ(ring.extent().dropped, 1U);
  EXPECT_FALSE(ring.put(numbered(number, image.view)));
  ASSERT_NE(ring.oldest_held(), nullptr);
  EXPECT_EQ(ring.oldest_held()->info.number, 4U);
  ring.let_go();
  EXPECT_TRUE(ring.put(numbered(number, image.view)));
  ring.hold(4'000'000, 6'000'000);
  EXPECT_THAT(held_numbers(ring), ::testing::ElementsAre(5, 6)) << "each is held once";
  EXPECT_TRUE(ring.put(numbered(number, image.view)));
  EXPECT_EQ(ring.extent().dropped, 2U);
}

TEST(ImageRing, ASecondClipMayHaveTheSameFrames) {
  ImageRing ring(kRingBytes);
  const OwnedImage image = noise_image(PixelFormat::kMono8, 256, 256, 1);
  for (std::uint32_t number = 1; number <= 5; ++number) ASSERT_TRUE(ring.put(numbered(number, image.view)));
  for (int clip = 0; clip < 2; ++clip) {
    ring.hold(2'000'000, 4'000'000);
    EXPECT_THAT(held_numbers(ring), ::testing::ElementsAre(2, 3, 4));
    ring.let_all_go();
  }
}

TEST(ImageRing, DropsFramesLargerThanItself) {
  ImageRing ring(1000);
  EXPECT_FALSE(ring.put(numbered(1, noise_image(PixelFormat::kMono8, 256, 256, 1).view)));
  EXPECT_EQ(ring.extent().frames, 0U);
  EXPECT_EQ(ring.extent().dropped, 1U);
  EXPECT_EQ(ring.extent().oldest_ns, 0);
}

TEST(ImageRing, AllocatesNothingForAFrame) {
  if (!counts_allocations()) GTEST_SKIP() << "the sanitizer has its own allocator";
  ImageRing ring(kRingBytes);
  const OwnedImage image = noise_image(PixelFormat::kMono8, 256, 200, 1);
  const std::uint64_t before = allocation_count();
  for (std::uint32_t number = 0; number < 100; ++number) ring.put(numbered(number, image.view));
  EXPECT_EQ(allocation_count(), before);
}

TEST(ImageRing, TheKeeperReadsWholeFramesWhileTheCameraGoesOn) {
  ImageRing ring(kRingBytes);
  std::atomic<bool> ends = false;
  std::thread camera([&] {
    std::vector<std::uint8_t> pixels(128 * 128);
    for (std::uint32_t number = 1; !ends; ++number) {
      std::fill(pixels.begin(), pixels.end(), static_cast<std::uint8_t>(number));
      ring.put(numbered(number, {pixels.data(), 128, 128, 128, PixelFormat::kMono8}));
    }
  });
  std::uint32_t last = 0;
  std::uint64_t frames = 0;
  while (frames < 1000) {
    const ImageRing::Extent extent = ring.extent();
    ring.hold(extent.oldest_ns, extent.newest_ns);
    while (const ClipFrame* frame = ring.oldest_held()) {
      ASSERT_GT(frame->info.number, last);
      last = frame->info.number;
      const auto pixels = pixels_of(frame->image);
      ASSERT_TRUE(std::ranges::all_of(
          pixels, [&](std::uint8_t pixel) { return pixel == static_cast<std::uint8_t>(last); }));
      ring.let_go();
      ++frames;
    }
  }
  ends = true;
  camera.join();
}

}  // namespace
}  // namespace sslv::image_ring_test
