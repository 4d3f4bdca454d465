// SPDX-License-Identifier: Apache-2.0
// libFuzzer: for any contents that a crashed process leaves in its ring's memory, the reader returns usable
// frames or throws a one-line error. The input modifies valid memory: each 12 bytes are a position and the
// new data; then the frames' heads get correct checksums. ./run test-long
#include "clips/clip_format.h"
#include "clips/image_ring.h"
#include "fuzz/expect.h"
#include "fuzz/live_bytes.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include <fcntl.h>
#include <sys/mman.h>

namespace sslv {

unsigned seen = 0;  // keeps the compiler from removing the reads

namespace {

constexpr std::size_t kBytes = 1 << 14;

void fill(ImageRing& ring) {
  const std::vector<std::uint8_t> pixels(2048, 7);
  const std::array<std::byte, 5> memory{};
  for (std::uint32_t number = 0; number < 9; ++number) {
    ring.put_setup(number, {1, Json{{"settings", Json::object()}}, std::vector<std::byte>(20)});
    ClipFrame frame;
    frame.info.number = frame.setup = number;
    frame.info.times.arrived_ns = number + 1;
    frame.image = {pixels.data(), 64, 32, 64, PixelFormat::kMono8};
    frame.packet = frame.memory = memory;
    ring.put(frame);
  }
}

void change(std::byte* memory, std::span<const std::uint8_t> input) {
  for (; input.size() >= 12; input = input.subspan(12)) {
    std::uint32_t place = 0;
    std::memcpy(&place, input.data(), sizeof place);
    // The ring's head, the used slots, or the frames.
    constexpr std::size_t kSlotsInUse = 16 * sizeof(RingSlot);
    constexpr std::array<std::array<std::size_t, 2>, 3> kParts{
        {{kRingMagic.size(), sizeof(RingHead)}, {kRingPage, kSlotsInUse}, {kRingBlocksAt, kBytes}}};
    const auto [begin, size] = kParts[place % kParts.size()];
    std::memcpy(memory + begin + place / 3 % (size - 8), input.data() + 4, 8);
  }
  for (std::size_t i = 0; i < 16; ++i) {
    const auto& slot = reinterpret_cast<const RingSlot*>(memory + kRingPage)[i];
    if (slot.begin > kBytes - kClipBlockBytes - kClipFrameBytes) continue;
    const std::span block(memory + kRingBlocksAt + slot.begin, kClipBlockBytes + kClipFrameBytes);
    put_u32(block, kClipBlockBytes - 4, clip_sum(block.first(kClipBlockBytes - 4)));
    const auto head = block.subspan(kClipBlockBytes);
    put_u32(head, kClipFrameBytes - 4, clip_sum(head.first(kClipFrameBytes - 4)));
  }
}

void read_all(ImageRing& ring) {
  ring.hold(0, std::numeric_limits<std::int64_t>::max());
  std::size_t frames = 0;
  while (const ClipFrame* frame = ring.oldest_held()) {
    expect(++frames <= ring.extent().frames, "more frames than there were");
    const ImageView& image = frame->image;
    if (!image.empty()) {
      expect(is_valid_size(image.format, image.width, image.height), "an image of a size that none has");
      const int row_bytes = image.width * bytes_per_pixel(image.format);
      for (const std::ptrdiff_t plane : {std::ptrdiff_t{0}, image.to_low_bits}) {
        for (int y = 0; y < image.height; ++y) {
          for (int x = 0; x < row_bytes; ++x) seen += (image.row(y) + plane)[x];
        }
      }
    }
    for (const auto part : {frame->packet, frame->memory}) {
      for (const std::byte byte : part) seen += std::to_integer<unsigned>(byte);
    }
    const std::vector<std::byte> setup = ring.setup(frame->setup);
    expect(setup.empty() || setup_in(setup).has_value(), "a setup that is none");
    ring.let_go();
  }
}

}  // namespace
}  // namespace sslv

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace sslv;
  const LiveBytes live(kMaxLiveBytes);
  ImageRing ring(kBytes);
  fill(ring);
  const std::size_t mapped = ring_mapped_bytes(ring.bytes());
  void* const memory = ::mmap(nullptr, mapped, PROT_READ | PROT_WRITE, MAP_SHARED, ring.fd(), 0);
  if (memory == MAP_FAILED) return 0;
  change(static_cast<std::byte*>(memory), {bytes, size});
  ::munmap(memory, mapped);
  try {
    ImageRing left(OpenFile(::fcntl(ring.fd(), F_DUPFD_CLOEXEC, 0)));
    read_all(left);
  } catch (const ClipError& error) {
    expect(!std::string(error.what()).empty(), "an error that says nothing");
  }
  return 0;
}
