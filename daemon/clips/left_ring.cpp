// SPDX-License-Identifier: Apache-2.0
#include "clips/left_ring.h"

#include "base/clock.h"
#include "clips/clip_format.h"
#include "clips/clip_reader.h"

#include <algorithm>
#include <array>
#include <exception>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

namespace sslv {
namespace {

bool read_at(const OpenFile& file, std::span<std::byte> bytes, std::uint64_t place) {
  while (!bytes.empty()) {
    const ssize_t got = ::pread(file.fd(), bytes.data(), bytes.size(), static_cast<off_t>(place));
    if (got <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(got));
    place += static_cast<std::uint64_t>(got);
  }
  return true;
}

/// The head and the slots; null: they cannot be mapped.
RingHead* map_head(const OpenFile& file) {
  void* const first = ::mmap(nullptr, kRingImagesAt, PROT_READ | PROT_WRITE, MAP_SHARED, file.fd(), 0);
  return first == MAP_FAILED ? nullptr : static_cast<RingHead*>(first);
}

void set_magic(RingHead& head, std::string_view magic) {
  head.magic = {};
  magic.copy(head.magic.data(), head.magic.size());
}

}  // namespace

LeftRing::LeftRing(OpenFile file) : file_(std::move(file)) {
  // One that may shrink could be gone while it is read, which kills the reader.
  const int seals = ::fcntl(file_.fd(), F_GET_SEALS);
  if (seals < 0 || (seals & F_SEAL_SHRINK) == 0) throw ClipError("it is no memory of last seconds");
  struct stat about {};
  if (::fstat(file_.fd(), &about) != 0 || about.st_size < static_cast<off_t>(ring_file_bytes(0)))
    throw ClipError("it is too small");
  const auto size = static_cast<std::uint64_t>(about.st_size);
  // Only now is it sure that the head and the slots are there.
  RingHead* const head = map_head(file_);
  if (head == nullptr) throw ClipError("it cannot be read");
  const std::string magic(head->magic.data(), head->magic.size());
  const bool is_known = magic.starts_with(kRingMagic);
  if (is_known) set_magic(*head, kRingIsRead);
  const std::uint64_t image_bytes = head->image_bytes;
  ::munmap(head, kRingImagesAt);
  if (magic.starts_with(kRingIsRead)) throw RingWasRead();
  if (!is_known) throw ClipError("it was left by another version, or ended well");
  // What it says must be its size, so that the sums below stay small.
  if (image_bytes > size || image_bytes != ring_aligned(image_bytes) || ring_file_bytes(image_bytes) != size)
    throw ClipError("its size is not the one that it says");
  image_bytes_ = static_cast<std::size_t>(image_bytes);
  void* const memory = ::mmap(nullptr, ring_mapped_bytes(image_bytes_), PROT_READ, MAP_SHARED, file_.fd(), 0);
  if (memory == MAP_FAILED) throw ClipError("it cannot be read");
  mapped_ = static_cast<std::byte*>(memory);
  look();
}

LeftRing::~LeftRing() {
  ::munmap(mapped_, ring_mapped_bytes(image_bytes_));
  if (is_put_back_) return;
  ::fallocate(file_.fd(), FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, 0,
              static_cast<off_t>(ring_file_bytes(image_bytes_)));
}

void LeftRing::put_back() noexcept {
  RingHead* const head = map_head(file_);
  if (head == nullptr) return;
  set_magic(*head, kRingMagic);
  ::munmap(head, kRingImagesAt);
  is_put_back_ = true;
}

bool LeftRing::may_be_there(std::uint64_t frame) const {
  const RingSlot& one = slot(frame);
  const std::uint64_t state = one.state.load(std::memory_order_acquire);
  const std::int64_t arrived_ns = one.arrived_ns.load(std::memory_order_relaxed);
  return (state == frame * 4 + kRingKept || state == frame * 4 + kRingHeld) && arrived_ns > 0 &&
         arrived_ns <= steady_ns();
}

void LeftRing::look() noexcept {
  next_ = head().begin.load(std::memory_order_acquire);
  end_ = head().end.load(std::memory_order_acquire);
  if (next_ > end_ || end_ - next_ > kRingSlots) next_ = end_ = 0;
  for (std::uint64_t frame = next_; frame != end_; ++frame) {
    if (!may_be_there(frame)) continue;
    const std::int64_t arrived_ns = slot(frame).arrived_ns.load(std::memory_order_relaxed);
    if (extent_.frames++ == 0 || arrived_ns < extent_.oldest_ns) extent_.oldest_ns = arrived_ns;
    extent_.newest_ns = std::max(extent_.newest_ns, arrived_ns);
    extent_.bytes += std::min<std::uint64_t>(slot(frame).payload_bytes, image_bytes_ - extent_.bytes);
  }
}

const ClipFrame* LeftRing::oldest() {
  for (; !has_oldest_ && next_ != end_; ++next_) {
    const auto frame = may_be_there(next_)
                           ? frame_in({mapped_ + kRingImagesAt, image_bytes_}, slot(next_), whole_)
                           : std::nullopt;
    if (!frame) {
      lacks_one_ = true;
      continue;
    }
    oldest_ = *frame;
    has_oldest_ = true;
  }
  return has_oldest_ ? &oldest_ : nullptr;
}

void LeftRing::drop_oldest() {
  has_oldest_ = false;
  lacks_one_ = false;
}

std::optional<ClipSetup> LeftRing::setup(std::uint32_t number) const {
  const std::uint64_t place = ring_setup_place(image_bytes_, number);
  std::array<std::byte, kRingSetupHeadBytes> head{};
  if (!read_at(file_, head, place) || u32_at(head, 0) != number) return std::nullopt;
  const std::uint64_t text_bytes = u64_at(head, 8), table_bytes = u64_at(head, 16);
  if (text_bytes > kMaxClipJsonBytes || table_bytes > kMaxClipTableBytes) return std::nullopt;
  std::vector<std::byte> text(text_bytes), table(table_bytes);
  if (!read_at(file_, text, place + head.size()) ||
      !read_at(file_, table, place + head.size() + text_bytes) ||
      clip_sum(table, clip_sum(text, clip_sum(std::span(head).first(24)))) != u32_at(head, 24))
    return std::nullopt;
  try {
    Json about = parse_bounded_json({reinterpret_cast<const char*>(text.data()), text.size()});
    if (!about.is_object()) return std::nullopt;
    return ClipSetup{static_cast<int>(u32_at(head, 4)), std::move(about), std::move(table)};
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

}  // namespace sslv
