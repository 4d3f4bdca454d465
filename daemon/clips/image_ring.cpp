// SPDX-License-Identifier: Apache-2.0
#include "clips/image_ring.h"

#include "base/clock.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace sslv {
namespace {

/// Copies large data with non-temporal stores: the image is not read soon, and the caches keep the working
/// data of the cameras' threads. This also saves reading the destination before it is written.
void copy_past_caches(std::byte* to, const std::byte* from, std::size_t bytes) noexcept {
#ifdef __SSE2__  // on every x86-64 processor; other processors use memcpy
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
    _mm_sfence();  // completes the stores before the frame is published
  }
#endif
  std::memcpy(to, from, bytes);
}

[[noreturn]] void refuse_memory(int problem) {
  throw std::system_error(problem, std::generic_category(), "memory for images");
}

/// An anonymous file of fixed size. Throws std::system_error.
OpenFile memory_file(std::uint64_t bytes) {
  OpenFile file(::memfd_create("last_seconds", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  if (!file.is_open() || ::ftruncate(file.fd(), static_cast<off_t>(bytes)) != 0 ||
      ::fcntl(file.fd(), F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0)
    refuse_memory(errno);
  return file;
}

/// Frees the memory of this range, which then reads as zeros.
void give_back(const OpenFile& file, std::uint64_t place, std::uint64_t bytes) {
  ::fallocate(file.fd(), FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, static_cast<off_t>(place),
              static_cast<off_t>(bytes));
}

constexpr std::size_t kHugePage = std::size_t{2} << 20U;
#ifndef MADV_COLLAPSE
#define MADV_COLLAPSE 25
#endif

/// Maps the file, aligned for huge pages. Throws std::system_error.
std::byte* map_memory(const OpenFile& file, std::size_t bytes) {
  const std::size_t room = bytes + kHugePage;
  void* const reserved = ::mmap(nullptr, room, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (reserved == MAP_FAILED) refuse_memory(errno);
  auto* const from = static_cast<std::byte*>(reserved);
  void* place = from;
  std::size_t left = room;
  std::align(kHugePage, bytes, place, left);
  void* const mapped = ::mmap(place, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_FIXED, file.fd(), 0);
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

bool read_at(const OpenFile& file, std::span<std::byte> bytes, std::uint64_t place) {
  while (!bytes.empty()) {
    const ssize_t got = ::pread(file.fd(), bytes.data(), bytes.size(), static_cast<off_t>(place));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(got));
    place += static_cast<std::uint64_t>(got);
  }
  return true;
}

void set_magic(RingHead& head, std::string_view magic) {
  head.magic = {};
  magic.copy(head.magic.data(), head.magic.size());
}

/// Returns the capacity for blocks of a crashed process's memory, and marks the memory as read. Throws
/// RingWasRead or ClipError.
std::size_t room_left_in(const OpenFile& file) {
  // If the file could shrink, reading the mapping could raise SIGBUS.
  const int seals = ::fcntl(file.fd(), F_GET_SEALS);
  if (seals < 0 || (seals & F_SEAL_SHRINK) == 0) throw ClipError("it is not an image ring");
  struct stat about {};
  if (::fstat(file.fd(), &about) != 0 || about.st_size < static_cast<off_t>(ring_file_bytes(0)))
    throw ClipError("it is too small");
  void* const page = ::mmap(nullptr, kRingPage, PROT_READ | PROT_WRITE, MAP_SHARED, file.fd(), 0);
  if (page == MAP_FAILED) throw ClipError("it cannot be read");
  auto& head = *static_cast<RingHead*>(page);
  const std::string magic(head.magic.data(), head.magic.size());
  const bool is_known = magic.starts_with(kRingMagic);
  if (is_known) set_magic(head, kRingIsRead);
  const std::uint64_t room = head.room, size = static_cast<std::uint64_t>(about.st_size);
  ::munmap(page, kRingPage);
  if (magic.starts_with(kRingIsRead)) throw RingWasRead();
  if (!is_known) throw ClipError("it was left by another version, or its process ended normally");
  // The capacity must match the size of the file, so that offsets cannot overflow.
  if (room > size || room != ring_aligned(room) || ring_file_bytes(room) != size)
    throw ClipError("its size does not match its header");
  return static_cast<std::size_t>(room);
}

/// The frame of a slot; nullopt if the slot or the block is damaged.
std::optional<ClipFrame> frame_of_slot(std::span<const std::byte> blocks, const RingSlot& slot) {
  if (slot.begin > blocks.size() || slot.bytes > blocks.size() - slot.begin ||
      slot.bytes < kClipBlockBytes + kClipFrameBytes)
    return std::nullopt;
  const auto block = blocks.subspan(slot.begin, slot.bytes);
  const auto payload = block.subspan(kClipBlockBytes);
  const auto block_head = block_head_of(block.first<kClipBlockBytes>());
  if (!block_head || block_head->bytes != payload.size()) return std::nullopt;
  const auto head = frame_head_of(payload.first<kClipFrameBytes>(), payload.size());
  if (!head || head->is_in_parts || head->image_bytes > kMaxClipImageBytes) return std::nullopt;
  const auto image = payload.last(static_cast<std::size_t>(head->image_bytes));
  ClipFrame out = frame_of(*head, block_head->camera_id, payload.subspan(kClipFrameBytes),
                           head->has_image() ? reinterpret_cast<const std::uint8_t*>(image.data()) : nullptr);
  out.info.times.arrived_ns = slot.arrived_ns.load(std::memory_order_relaxed);
  return out;
}

/// Calls copy(data, bytes) for the image's rows, plane by plane; once per plane if its rows have no gaps.
template <class Copy>
void each_stretch(const ImageView& image, const Copy& copy) {
  const std::size_t row_bytes = clip_plane_bytes(image.format, image.width, 1);
  const bool is_tight = image.stride_bytes == static_cast<std::ptrdiff_t>(row_bytes);
  for (int plane = 0; plane < (image.to_low_bits != 0 ? 2 : 1); ++plane) {
    const std::ptrdiff_t shift = plane == 0 ? 0 : image.to_low_bits;
    if (is_tight) {
      copy(image.data + shift, row_bytes * static_cast<std::size_t>(image.height));
    } else {
      for (int y = 0; y < image.height; ++y) copy(image.row(y) + shift, row_bytes);
    }
  }
}

}  // namespace

ImageRing::ImageRing(std::size_t bytes, const std::stop_token& stop)
    : file_(memory_file(ring_file_bytes(ring_aligned(bytes)))), room_(ring_aligned(bytes)) {
  const std::size_t size = ring_mapped_bytes(room_);
  mapped_ = map_memory(file_, size);
  madvise(mapped_, size, MADV_HUGEPAGE);  // fewer TLB misses; harmless where unsupported
  madvise(mapped_, size, MADV_DONTDUMP);
  // In chunks, because no other thread of this process can allocate memory during a call.
  for (std::size_t at = 0; at < size; at += kHugePage) {
    const std::size_t piece = std::min(kHugePage, size - at);
    const bool is_stopped = stop.stop_requested();
    if (is_stopped || madvise(mapped_ + at, piece, MADV_POPULATE_WRITE) != 0) {
      const int problem = errno;
      if (is_stopped || problem == ENOMEM || problem == EFAULT) {
        munmap(mapped_, size);
        refuse_memory(is_stopped ? ECANCELED : ENOMEM);
      }
      std::memset(mapped_ + at, 0, piece);  // for kernels without MADV_POPULATE_WRITE
    }
    // Memory files have small pages unless the system is configured otherwise. Since Linux 6.1 MADV_COLLAPSE
    // requests a huge page; if no huge page is available, small pages are enough.
    if (piece == kHugePage) madvise(mapped_ + at, piece, MADV_COLLAPSE);
  }
  make_head();
}

ImageRing::ImageRing(OpenFile left) : file_(std::move(left)), room_(room_left_in(file_)) {
  void* const memory =
      ::mmap(nullptr, ring_mapped_bytes(room_), PROT_READ | PROT_WRITE, MAP_SHARED, file_.fd(), 0);
  if (memory == MAP_FAILED) throw ClipError("it cannot be read");
  mapped_ = static_cast<std::byte*>(memory);
  leave_out_damaged();
}

ImageRing::~ImageRing() {
  munmap(mapped_, ring_mapped_bytes(room_));
  // Another process may still have the file open, so free the memory with the frames explicitly.
  if (!is_put_back_) give_back(file_, 0, ring_file_bytes(room_));
}

void ImageRing::put_back() noexcept {
  let_all_go();
  set_magic(head(), kRingMagic);
  is_put_back_ = true;
}

void ImageRing::make_head() noexcept {
  std::uninitialized_value_construct_n(reinterpret_cast<RingSlot*>(mapped_ + kRingPage), kRingSlots);
  RingHead& made = *std::construct_at(reinterpret_cast<RingHead*>(mapped_));
  made.room = room_;
  set_magic(made, kRingMagic);
}

/// Marks damaged frames as empty and releases held frames. Afterwards the first and the last frame in [begin,
/// end) are intact.
void ImageRing::leave_out_damaged() noexcept {
  std::uint64_t begin = head().begin.load(std::memory_order_relaxed);
  std::uint64_t end = head().end.load(std::memory_order_relaxed);
  if (begin > end || end - begin > kRingSlots) begin = end = 0;
  const auto is_valid = [this, now_ns = steady_ns()](std::uint64_t frame) {
    const RingSlot& one = slot(frame);
    const std::uint64_t state = one.state.load(std::memory_order_relaxed);
    const std::int64_t arrived_ns = one.arrived_ns.load(std::memory_order_relaxed);
    return (state == frame * 4 + kRingKept || state == frame * 4 + kRingHeld) && arrived_ns > 0 &&
           arrived_ns <= now_ns && frame_of_slot({blocks(), room_}, one).has_value();
  };
  for (std::uint64_t frame = begin; frame != end; ++frame)
    slot(frame).state.store(frame * 4 + (is_valid(frame) ? kRingKept : kRingEmpty),
                            std::memory_order_relaxed);
  const auto is_empty = [this](std::uint64_t frame) {
    return slot(frame).state.load(std::memory_order_relaxed) == frame * 4 + kRingEmpty;
  };
  while (begin != end && is_empty(begin)) ++begin;
  while (begin != end && is_empty(end - 1)) --end;
  head().begin.store(begin, std::memory_order_relaxed);
  head().end.store(end, std::memory_order_relaxed);
}

ImageRing::Extent ImageRing::extent() const noexcept {
  Extent out;
  out.dropped = head().dropped.load(std::memory_order_relaxed);
  // Read again if the oldest frame was removed meanwhile.
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

/// Frees these bytes for a block: removes the oldest frames that overlap them, that lie after at_ if the ring
/// wraps (`from_the_start`), or that occupy the needed slot. False if the keeper holds one of these frames.
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
  const ImageView& image = frame.image;
  const std::size_t image_bytes = clip_image_bytes(image);
  ClipFrameHead about{.info = frame.info,
                      .setup = frame.setup,
                      .format = image.format,
                      .width = image.empty() ? 0 : image.width,
                      .height = image.empty() ? 0 : image.height,
                      .is_deep = image.to_low_bits != 0,
                      .packet_bytes = frame.packet.size(),
                      .memory_bytes = frame.memory.size(),
                      .image_bytes = image_bytes};
  leave_out_bad_times(about.info.times);
  const auto head_bytes = encoded(about);
  const std::size_t payload_bytes =
      head_bytes.size() + frame.packet.size() + frame.memory.size() + image_bytes;
  const auto block_head = encoded(ClipBlockHead{.type = static_cast<std::uint32_t>(ClipBlock::kFrame),
                                                .camera_id = frame.info.camera_id,
                                                .bytes = payload_bytes,
                                                .time_ns = clip_ns(frame.info.times.t_capture_s)});
  // Aligns the image to a cache line for copy_past_caches().
  const std::size_t small = block_head.size() + payload_bytes - image_bytes;
  const std::size_t bytes = ring_aligned(small) + ring_aligned(image_bytes);
  const bool from_the_start = at_ + bytes > room_;
  const std::size_t begin = from_the_start ? 0 : at_;
  const bool is_good = bytes <= room_ && image_bytes <= kMaxClipImageBytes &&
                       frame_head_of(head_bytes, payload_bytes).has_value();
  if (!is_good || !make_room(begin, bytes, from_the_start)) {
    head().dropped.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  const std::size_t block_at = begin + ring_aligned(small) - small;
  std::byte* to = blocks() + block_at;
  const auto copy = [&to](const void* from, std::size_t count) {
    if (count != 0) copy_past_caches(to, static_cast<const std::byte*>(from), count);
    to += count;
  };
  copy(block_head.data(), block_head.size());
  copy(head_bytes.data(), head_bytes.size());
  copy(frame.packet.data(), frame.packet.size());
  copy(frame.memory.data(), frame.memory.size());
  if (image_bytes != 0) each_stretch(image, copy);

  const std::uint64_t number = head().end.load(std::memory_order_relaxed);
  RingSlot& one = slot(number);
  one.begin = block_at;
  one.bytes = block_head.size() + payload_bytes;
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
    if (one.state.load(std::memory_order_acquire) != kept) continue;  // overwritten meanwhile
    const std::int64_t arrived_ns = one.arrived_ns.load(std::memory_order_relaxed);
    if (arrived_ns > to_ns) break;
    // Fails if the slot was reused for another frame meanwhile.
    if (arrived_ns >= from_ns &&
        one.state.compare_exchange_strong(kept, frame * 4 + kRingHeld, std::memory_order_acq_rel))
      held_.push_back(frame);
    next_to_hold_ = frame + 1;
  }
}

std::uint64_t ImageRing::held_bytes() const {
  std::uint64_t out = 0;
  for (const std::uint64_t frame : held_) out += slot(frame).bytes;
  return out;
}

const ClipFrame* ImageRing::oldest_held() {
  for (; !held_.empty(); let_go()) {
    const auto frame = frame_of_slot({blocks(), room_}, slot(held_.front()));
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
  next_to_hold_ = 0;  // another clip may hold the same frames again
}

void ImageRing::put_setup(std::uint32_t number, const ClipSetup& setup) {
  const std::string about = json_text(setup.about);
  if (about.size() > kMaxClipJsonBytes || setup.table.size() > kMaxClipTableBytes)
    throw ClipError("they are larger than a clip can hold");
  if (number >= kRingSetups) forget_setups_before(number - kRingSetups + 1);
  const auto json = std::as_bytes(std::span(about));
  const auto setup_bytes = setup_head(number, json.size());
  const auto block_head =
      encoded(ClipBlockHead{.type = static_cast<std::uint32_t>(ClipBlock::kSetup),
                            .camera_id = static_cast<std::uint32_t>(setup.camera_id),
                            .bytes = setup_bytes.size() + json.size() + setup.table.size(),
                            .sum = clip_sum(setup.table, clip_sum(json, clip_sum(setup_bytes)))});
  setups_.push_back(number);
  std::uint64_t place = ring_setup_place(room_, number);
  for (const std::span<const std::byte> part :
       {std::span<const std::byte>(block_head), std::span<const std::byte>(setup_bytes), json,
        std::span<const std::byte>(setup.table)}) {
    if (!write_at(file_, part, place)) {
      free_setup(number);
      throw ClipError("there is not enough memory for them");
    }
    place += part.size();
  }
}

std::vector<std::byte> ImageRing::setup(std::uint32_t number) const {
  const std::uint64_t place = ring_setup_place(room_, number);
  std::array<std::byte, kClipBlockBytes> bytes{};
  if (!read_at(file_, bytes, place)) return {};
  const auto head = block_head_of(bytes);
  if (!head || head->type != static_cast<std::uint32_t>(ClipBlock::kSetup) ||
      head->bytes > kRingSetupBytes - kClipBlockBytes)
    return {};
  std::vector<std::byte> payload(static_cast<std::size_t>(head->bytes));
  if (!read_at(file_, payload, place + bytes.size()) || clip_sum(payload) != head->sum) return {};
  const auto parts = setup_in(payload);
  return parts && parts->number == number ? std::move(payload) : std::vector<std::byte>{};
}

void ImageRing::free_setup(std::uint32_t number) const {
  give_back(file_, ring_setup_place(room_, number), kRingSetupBytes);
}

void ImageRing::forget_setups_before(std::uint32_t number) {
  for (; !setups_.empty() && setups_.front() < number; setups_.pop_front()) free_setup(setups_.front());
}

}  // namespace sslv
