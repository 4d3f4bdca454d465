// SPDX-License-Identifier: Apache-2.0
#include "clips/image_ring.h"

#include "clips/clip_format.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <sys/mman.h>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace sslv {
namespace {

/// Copies past the processor's caches where it is much: nobody reads the image here soon, and what cameras'
/// threads work with shall stay in them. It also saves reading the place before it is written.
void copy_past_caches(std::byte* to, const std::byte* from, std::size_t bytes) noexcept {
#ifdef __SSE2__  // as every x86-64 has; elsewhere a plain copy does
  constexpr std::size_t kLine = 64, kMuch = std::size_t{64} << 10U;
  if (bytes >= kMuch && reinterpret_cast<std::uintptr_t>(to) % kLine == 0) {
    for (; bytes >= kLine; bytes -= kLine, from += kLine, to += kLine) {
      const auto* const in = reinterpret_cast<const __m128i*>(from);
      auto* const out = reinterpret_cast<__m128i*>(to);
      const __m128i a = _mm_loadu_si128(in), b = _mm_loadu_si128(in + 1);
      const __m128i c = _mm_loadu_si128(in + 2), d = _mm_loadu_si128(in + 3);
      _mm_stream_si128(out, a);
      _mm_stream_si128(out + 1, b);
      _mm_stream_si128(out + 2, c);
      _mm_stream_si128(out + 3, d);
    }
    _mm_sfence();  // before others are told that the image is there
  }
#endif
  std::memcpy(to, from, bytes);
}

[[noreturn]] void refuse_memory(int problem) {
  throw std::system_error(problem, std::generic_category(), "memory for images");
}

/// A file without a name; closed: the system has none.
OpenFile memory_file(std::uint64_t bytes) {
  OpenFile file(::memfd_create("last_seconds", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  if (!file.is_open() || ::ftruncate(file.fd(), static_cast<off_t>(bytes)) != 0 ||
      ::fcntl(file.fd(), F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0)
    return {};
  return file;
}

/// Gives back what part of the file has; it reads as zeros from then on.
void give_back(const OpenFile& file, std::uint64_t place, std::uint64_t bytes) {
  if (file.is_open())
    ::fallocate(file.fd(), FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, static_cast<off_t>(place),
                static_cast<off_t>(bytes));
}

constexpr std::size_t kHugePage = std::size_t{2} << 20U;
#ifndef MADV_COLLAPSE
#define MADV_COLLAPSE 25
#endif

/// The file, or memory without one, at a place where huge pages may be. Throws std::system_error.
std::byte* map_memory(const OpenFile& file, std::size_t bytes) {
  const std::size_t room = bytes + kHugePage;
  void* const reserved = ::mmap(nullptr, room, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (reserved == MAP_FAILED) refuse_memory(errno);
  auto* const from = static_cast<std::byte*>(reserved);
  void* place = from;
  std::size_t left = room;
  std::align(kHugePage, bytes, place, left);
  const int how = file.is_open() ? MAP_SHARED : MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE;
  void* const mapped = ::mmap(place, bytes, PROT_READ | PROT_WRITE, how | MAP_FIXED, file.fd(), 0);
  if (mapped == MAP_FAILED) {
    const int problem = errno;
    ::munmap(reserved, room);
    refuse_memory(problem);
  }
  auto* const begin = static_cast<std::byte*>(mapped);
  if (begin != from) ::munmap(from, static_cast<std::size_t>(begin - from));
  ::munmap(begin + bytes, static_cast<std::size_t>(from + room - (begin + bytes)));
  return begin;
}

bool write_at(const OpenFile& file, std::span<const std::byte> bytes, std::uint64_t place) {
  while (!bytes.empty()) {
    const ssize_t got = ::pwrite(file.fd(), bytes.data(), bytes.size(), static_cast<off_t>(place));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(got));
    place += static_cast<std::uint64_t>(got);
  }
  return true;
}

}  // namespace

ImageRing::ImageRing(std::size_t bytes, const std::stop_token& stop)
    : bytes_(ring_aligned(bytes)), file_(memory_file(ring_file_bytes(bytes_))) {
  const std::size_t size = ring_mapped_bytes(bytes_);
  mapped_ = map_memory(file_, size);
  madvise(mapped_, size, MADV_HUGEPAGE);  // fewer pages to look up; it is no harm where there are none
  madvise(mapped_, size, MADV_DONTDUMP);
  // In pieces: the kernel lets no other thread of this process get memory meanwhile.
  for (std::size_t at = 0; at < size; at += kHugePage) {
    const std::size_t piece = std::min(kHugePage, size - at);
    const bool is_stopped = stop.stop_requested();
    if (is_stopped || madvise(mapped_ + at, piece, MADV_POPULATE_WRITE) != 0) {
      const int problem = errno;
      if (is_stopped || problem == ENOMEM || problem == EFAULT) {
        munmap(mapped_, size);
        refuse_memory(is_stopped ? ECANCELED : ENOMEM);
      }
      std::memset(mapped_ + at, 0, piece);  // an older kernel
    }
    // Files in memory have small pages unless the whole computer is told otherwise; or one asks, since Linux
    // 6.1. If there is no huge page, small ones do.
    if (file_.is_open() && piece == kHugePage) madvise(mapped_ + at, piece, MADV_COLLAPSE);
  }
  make_head();
}

void ImageRing::make_head() noexcept {
  std::uninitialized_value_construct_n(reinterpret_cast<RingSlot*>(mapped_ + kRingPage), kRingSlots);
  RingHead& made = *std::construct_at(reinterpret_cast<RingHead*>(mapped_));
  made.image_bytes = bytes_;
  kRingMagic.copy(made.magic.data(), made.magic.size());
}

ImageRing::~ImageRing() {
  munmap(mapped_, ring_mapped_bytes(bytes_));
  // Others may have it open still: they shall hold no memory, and find nothing.
  give_back(file_, 0, ring_file_bytes(bytes_));
}

ImageRing::Extent ImageRing::extent() const noexcept {
  Extent out;
  out.dropped = head().dropped.load(std::memory_order_relaxed);
  // The oldest may go while it is looked at: then the next one is the oldest.
  for (;;) {
    const std::uint64_t begin = head().begin.load(std::memory_order_acquire);
    const std::uint64_t end = head().end.load(std::memory_order_acquire);
    if (begin == end) return out;
    out.frames = end - begin;
    out.oldest_ns = slot(begin).arrived_ns.load(std::memory_order_relaxed);
    out.oldest_setup = slot(begin).setup.load(std::memory_order_relaxed);
    out.newest_ns = slot(end - 1).arrived_ns.load(std::memory_order_relaxed);
    std::atomic_thread_fence(std::memory_order_acquire);
    if (head().begin.load(std::memory_order_relaxed) == begin) return out;
  }
}

/// Lets the oldest frames go that lie there, and, when the next one begins again `from_the_start`, those
/// behind the last one. False when the keeper holds one of them.
bool ImageRing::make_room(std::size_t begin, std::size_t bytes, bool from_the_start) noexcept {
  for (std::uint64_t oldest = head().begin.load(std::memory_order_relaxed);
       oldest != head().end.load(std::memory_order_relaxed); ++oldest) {
    RingSlot& one = slot(oldest);
    const bool is_in_the_way = one.begin < begin + bytes && begin < one.begin + one.bytes;
    const bool is_behind = from_the_start && one.begin >= at_;
    const bool is_one_too_many = head().end.load(std::memory_order_relaxed) - oldest >= kRingSlots;
    if (!is_in_the_way && !is_behind && !is_one_too_many) return true;
    std::uint64_t kept = oldest * 4 + kRingKept;
    if (!one.state.compare_exchange_strong(kept, oldest * 4 + kRingEmpty, std::memory_order_acq_rel))
      return false;
    head().begin.store(oldest + 1, std::memory_order_release);
  }
  return true;
}

bool ImageRing::put(const ClipFrame& frame) noexcept {
  const std::size_t image_bytes = frame.image.empty() ? 0 : ring_image_bytes(frame);
  ClipFrameHead about{.info = frame.info,
                      .setup = frame.setup,
                      .format = frame.image.format,
                      .width = frame.image.width,
                      .height = frame.image.height,
                      .is_deep = frame.image.to_low_bits != 0,
                      .tile_px = frame.tile_px,
                      .packet_bytes = frame.packet.size(),
                      .memory_bytes = frame.memory.size(),
                      .tiles_bytes = frame.tiles.size(),
                      .image_bytes = image_bytes};
  leave_out_bad_times(about.info.times);
  const auto head_bytes = encoded(about);
  const std::size_t small =
      head_bytes.size() + frame.packet.size() + frame.memory.size() + frame.tiles.size();
  const std::size_t bytes = ring_aligned(small) + ring_aligned(image_bytes);
  const bool from_the_start = at_ + bytes > bytes_;
  const std::size_t begin = from_the_start ? 0 : at_;
  const bool is_good = bytes <= bytes_ && frame_head_of(head_bytes, small + image_bytes, 1).has_value();
  if (!is_good || !make_room(begin, bytes, from_the_start)) {
    head().dropped.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  std::byte* to = images() + begin;
  const auto copy = [&to](const void* from, std::size_t count) {
    if (count != 0) copy_past_caches(to, static_cast<const std::byte*>(from), count);
    to += count;
  };
  copy(head_bytes.data(), head_bytes.size());
  copy(frame.packet.data(), frame.packet.size());
  copy(frame.memory.data(), frame.memory.size());
  copy(frame.tiles.data(), frame.tiles.size());
  to = images() + begin + ring_aligned(small);
  if (image_bytes != 0) each_stretch(frame, copy);

  const std::uint64_t number = head().end.load(std::memory_order_relaxed);
  RingSlot& one = slot(number);
  one.begin = begin;
  one.bytes = bytes;
  one.payload_bytes = small + image_bytes;
  one.camera_id = frame.info.camera_id;
  one.arrived_ns.store(frame.info.times.arrived_ns, std::memory_order_relaxed);
  one.setup.store(frame.setup, std::memory_order_relaxed);
  one.state.store(number * 4 + kRingKept, std::memory_order_release);
  head().end.store(number + 1, std::memory_order_release);
  at_ = begin + bytes;
  return true;
}

void ImageRing::hold(std::int64_t from_ns, std::int64_t to_ns) {
  const std::uint64_t end = head().end.load(std::memory_order_acquire);
  for (std::uint64_t frame = std::max(next_to_hold_, head().begin.load(std::memory_order_acquire));
       frame < end; ++frame) {
    RingSlot& one = slot(frame);
    std::uint64_t kept = frame * 4 + kRingKept;
    if (one.state.load(std::memory_order_acquire) != kept) continue;  // it has gone meanwhile
    const std::int64_t arrived_ns = one.arrived_ns.load(std::memory_order_relaxed);
    if (arrived_ns > to_ns) break;
    // When the slot went on to another frame since, this does not succeed.
    if (arrived_ns >= from_ns &&
        one.state.compare_exchange_strong(kept, frame * 4 + kRingHeld, std::memory_order_acq_rel))
      held_.push_back(frame);
    next_to_hold_ = frame + 1;
  }
}

const ClipFrame* ImageRing::oldest_held() {
  for (; !held_.empty(); let_go()) {
    const auto frame = frame_in({images(), bytes_}, slot(held_.front()), whole_);
    if (!frame) continue;
    oldest_ = *frame;
    return &oldest_;
  }
  return nullptr;
}

void ImageRing::let_go() {
  const std::uint64_t frame = held_.front();
  held_.pop_front();
  slot(frame).state.store(frame * 4 + kRingKept, std::memory_order_release);
}

void ImageRing::let_all_go() {
  while (!held_.empty()) let_go();
  next_to_hold_ = 0;  // another clip may want the same frames again
}

void ImageRing::put_setup(std::uint32_t number, const ClipSetup& setup) {
  if (!file_.is_open()) return;
  const std::string about = setup.about.dump(-1, ' ', false, Json::error_handler_t::replace);
  if (about.size() > kMaxClipJsonBytes || setup.table.size() > kMaxClipTableBytes) return;
  if (number >= kRingSetups) forget_setups_before(number - kRingSetups + 1);
  const auto text = std::as_bytes(std::span(about));
  std::array<std::byte, kRingSetupHeadBytes> head{};
  put_u32(head, 0, number);
  put_u32(head, 4, static_cast<std::uint32_t>(setup.camera_id));
  put_u64(head, 8, text.size());
  put_u64(head, 16, setup.table.size());
  put_u32(head, 24, clip_sum(setup.table, clip_sum(text, clip_sum(std::span(head).first(24)))));
  const std::uint64_t place = ring_setup_place(bytes_, number) + head.size();
  setups_.push_back(number);
  if (!write_at(file_, text, place) || !write_at(file_, setup.table, place + text.size()) ||
      !write_at(file_, head, place - head.size()))
    free_setup(number);
}

void ImageRing::free_setup(std::uint32_t number) const {
  give_back(file_, ring_setup_place(bytes_, number), kRingSetupBytes);
}

void ImageRing::forget_setups_before(std::uint32_t number) {
  for (; !setups_.empty() && setups_.front() < number; setups_.pop_front()) free_setup(setups_.front());
}

}  // namespace sslv
