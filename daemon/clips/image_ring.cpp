// SPDX-License-Identifier: Apache-2.0
#include "clips/image_ring.h"

#include "clips/clip_format.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <span>
#include <system_error>

#include <sys/mman.h>

namespace sslv {
namespace {

constexpr std::size_t kAlignment = 64;

constexpr std::size_t aligned(std::size_t bytes) {
  return (bytes + kAlignment - 1) / kAlignment * kAlignment;
}

/// What stands before each frame in the ring.
struct RingHead {
  FrameInfo info;
  std::uint32_t setup = 0;
  int width = 0, height = 0, tile_px = 0;
  PixelFormat format = PixelFormat::kMono8;
  bool has_low_bits = false;
  std::size_t packet_bytes = 0, memory_bytes = 0, tiles_bytes = 0;
};
static_assert(std::is_trivially_copyable_v<RingHead>);

/// One plane after the other, each row by row: all of it, or the tiles that are marked.
template <class Copy>
void each_stretch(const ClipFrame& frame, const Copy& copy) {
  const ImageView& image = frame.image;
  const std::size_t pixel = static_cast<std::size_t>(bytes_per_pixel(image.format));
  for (int plane = 0; plane < (image.to_low_bits != 0 ? 2 : 1); ++plane) {
    const std::ptrdiff_t shift = plane == 0 ? 0 : image.to_low_bits;
    if (frame.tile_px == 0) {
      const std::size_t row_bytes = static_cast<std::size_t>(image.width) * pixel;
      if (image.stride_bytes == static_cast<std::ptrdiff_t>(row_bytes)) {
        copy(image.data + shift, row_bytes * static_cast<std::size_t>(image.height));
      } else {
        for (int y = 0; y < image.height; ++y) copy(image.row(y) + shift, row_bytes);
      }
      continue;
    }
    const ClipTiles tiles{image.width, image.height, frame.tile_px};
    tiles.each_row(frame.tiles, [&](int x, int y, int pixels) {
      copy(image.row(y) + shift + static_cast<std::size_t>(x) * pixel,
           static_cast<std::size_t>(pixels) * pixel);
    });
  }
}

std::size_t image_bytes(const ClipFrame& frame) {
  const ImageView& image = frame.image;
  const std::size_t planes = image.to_low_bits != 0 ? 2 : 1;
  if (frame.tile_px == 0) return planes * clip_plane_bytes(image.format, image.width, image.height);
  const std::uint64_t pixels = ClipTiles{image.width, image.height, frame.tile_px}.pixels(frame.tiles);
  return planes * static_cast<std::size_t>(pixels) * static_cast<std::size_t>(bytes_per_pixel(image.format));
}

}  // namespace

ImageRing::ImageRing(std::size_t bytes) : bytes_(aligned(bytes)), slots_(new Slot[kSlots]) {
  void* const memory =
      mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (memory == MAP_FAILED) throw std::system_error(errno, std::generic_category(), "memory for images");
  memory_ = static_cast<std::byte*>(memory);
  madvise(memory, bytes_, MADV_HUGEPAGE);  // fewer pages to look up; it is no harm where there are none
  madvise(memory, bytes_, MADV_DONTDUMP);
  // In pieces: the kernel lets no other thread of this process get memory meanwhile.
  constexpr std::size_t kPiece = std::size_t{4} << 20U;
  for (std::size_t at = 0; at < bytes_; at += kPiece) {
    const std::size_t piece = std::min(kPiece, bytes_ - at);
    if (madvise(memory_ + at, piece, MADV_POPULATE_WRITE) == 0) continue;
    const int problem = errno;
    if (problem == ENOMEM || problem == EFAULT) {
      munmap(memory, bytes_);
      throw std::system_error(ENOMEM, std::generic_category(), "memory for images");
    }
    std::memset(memory_ + at, 0, piece);  // an older kernel
  }
}

ImageRing::~ImageRing() {
  munmap(memory_, bytes_);
}

ImageRing::Extent ImageRing::extent() const noexcept {
  Extent out;
  out.dropped = dropped_.load(std::memory_order_relaxed);
  // The oldest may go while it is looked at: then the next one is the oldest.
  for (;;) {
    const std::uint64_t begin = begin_.load(std::memory_order_acquire);
    const std::uint64_t end = end_.load(std::memory_order_acquire);
    if (begin == end) return out;
    out.frames = end - begin;
    out.oldest_ns = slot(begin).arrived_ns.load(std::memory_order_relaxed);
    out.oldest_setup = slot(begin).setup.load(std::memory_order_relaxed);
    out.newest_ns = slot(end - 1).arrived_ns.load(std::memory_order_relaxed);
    std::atomic_thread_fence(std::memory_order_acquire);
    if (begin_.load(std::memory_order_relaxed) == begin) return out;
  }
}

/// Lets the oldest frames go that lie there, and, when the next one begins again `from_the_start`, those
/// behind the last one. False when the keeper holds one of them.
bool ImageRing::make_room(std::size_t begin, std::size_t bytes, bool from_the_start) noexcept {
  for (std::uint64_t oldest = begin_.load(std::memory_order_relaxed);
       oldest != end_.load(std::memory_order_relaxed); ++oldest) {
    Slot& one = slot(oldest);
    const bool is_in_the_way = one.begin < begin + bytes && begin < one.begin + one.bytes;
    const bool is_behind = from_the_start && one.begin >= at_;
    const bool is_one_too_many = end_.load(std::memory_order_relaxed) - oldest >= kSlots;
    if (!is_in_the_way && !is_behind && !is_one_too_many) return true;
    std::uint64_t kept = oldest * 4 + kKept;
    if (!one.state.compare_exchange_strong(kept, oldest * 4 + kEmpty, std::memory_order_acq_rel))
      return false;
    begin_.store(oldest + 1, std::memory_order_release);
  }
  return true;
}

bool ImageRing::put(const ClipFrame& frame) noexcept {
  RingHead head{.info = frame.info,
                .setup = frame.setup,
                .width = frame.image.width,
                .height = frame.image.height,
                .tile_px = frame.tile_px,
                .format = frame.image.format,
                .has_low_bits = frame.image.to_low_bits != 0,
                .packet_bytes = frame.packet.size(),
                .memory_bytes = frame.memory.size(),
                .tiles_bytes = frame.tiles.size()};
  const std::size_t small = sizeof head + head.packet_bytes + head.memory_bytes + head.tiles_bytes;
  const std::size_t bytes = aligned(small) + aligned(image_bytes(frame));
  const bool from_the_start = at_ + bytes > bytes_;
  const std::size_t begin = from_the_start ? 0 : at_;
  if (bytes > bytes_ || !make_room(begin, bytes, from_the_start)) {
    dropped_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  std::byte* to = memory_ + begin;
  const auto copy = [&to](const void* from, std::size_t count) {
    if (count != 0) std::memcpy(to, from, count);
    to += count;
  };
  copy(&head, sizeof head);
  copy(frame.packet.data(), frame.packet.size());
  copy(frame.memory.data(), frame.memory.size());
  copy(frame.tiles.data(), frame.tiles.size());
  to = memory_ + begin + aligned(small);
  each_stretch(frame, copy);

  const std::uint64_t number = end_.load(std::memory_order_relaxed);
  Slot& one = slot(number);
  one.begin = begin;
  one.bytes = bytes;
  one.arrived_ns.store(frame.info.times.arrived_ns, std::memory_order_relaxed);
  one.setup.store(frame.setup, std::memory_order_relaxed);
  one.state.store(number * 4 + kKept, std::memory_order_release);
  end_.store(number + 1, std::memory_order_release);
  at_ = begin + bytes;
  return true;
}

void ImageRing::hold(std::int64_t from_ns, std::int64_t to_ns) {
  const std::uint64_t end = end_.load(std::memory_order_acquire);
  for (std::uint64_t frame = std::max(next_to_hold_, begin_.load(std::memory_order_acquire)); frame < end;
       ++frame) {
    Slot& one = slot(frame);
    std::uint64_t kept = frame * 4 + kKept;
    if (one.state.load(std::memory_order_acquire) != kept) continue;  // it has gone meanwhile
    const std::int64_t arrived_ns = one.arrived_ns.load(std::memory_order_relaxed);
    if (arrived_ns > to_ns) break;
    // When the slot went on to another frame since, this does not succeed.
    if (arrived_ns >= from_ns &&
        one.state.compare_exchange_strong(kept, frame * 4 + kHeld, std::memory_order_acq_rel))
      held_.push_back(frame);
    next_to_hold_ = frame + 1;
  }
}

const ClipFrame* ImageRing::oldest_held() {
  if (held_.empty()) return nullptr;
  const Slot& one = slot(held_.front());
  const std::byte* at = memory_ + one.begin;
  RingHead head;
  std::memcpy(&head, at, sizeof head);
  at += sizeof head;
  const auto next = [&at](std::size_t count) {
    const std::span out(at, count);
    at += count;
    return out;
  };
  oldest_ = {};
  oldest_.info = head.info;
  oldest_.setup = head.setup;
  oldest_.packet = next(head.packet_bytes);
  oldest_.memory = next(head.memory_bytes);
  oldest_.tiles = next(head.tiles_bytes);
  oldest_.tile_px = head.tile_px;
  const std::size_t small = sizeof head + head.packet_bytes + head.memory_bytes + head.tiles_bytes;
  const std::byte* pixels = memory_ + one.begin + aligned(small);
  const std::size_t row_bytes =
      static_cast<std::size_t>(head.width) * static_cast<std::size_t>(bytes_per_pixel(head.format));
  const std::size_t plane_bytes = row_bytes * static_cast<std::size_t>(head.height);
  if (head.tile_px != 0) whole_.resize(plane_bytes * (head.has_low_bits ? 2 : 1));
  const std::byte* const data = head.tile_px != 0 ? whole_.data() : pixels;
  oldest_.image = {.data = reinterpret_cast<const std::uint8_t*>(data),
                   .width = head.width,
                   .height = head.height,
                   .stride_bytes = static_cast<std::ptrdiff_t>(row_bytes),
                   .format = head.format,
                   .to_low_bits = head.has_low_bits ? static_cast<std::ptrdiff_t>(plane_bytes) : 0};
  if (head.tile_px != 0) {
    each_stretch(oldest_, [&](const std::uint8_t* stretch, std::size_t count) {
      std::memcpy(whole_.data() + (stretch - oldest_.image.data), pixels, count);
      pixels += count;
    });
  }
  return &oldest_;
}

void ImageRing::let_go() {
  const std::uint64_t frame = held_.front();
  held_.pop_front();
  slot(frame).state.store(frame * 4 + kKept, std::memory_order_release);
}

void ImageRing::let_all_go() {
  while (!held_.empty()) let_go();
  next_to_hold_ = 0;  // another clip may want the same frames again
}

}  // namespace sslv
