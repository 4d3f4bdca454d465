// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/open_file.h"
#include "clips/clip.h"
#include "clips/clip_reader.h"
#include "clips/ring_layout.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace sslv {

/// The memory was read before, by a process that did not come to its end.
struct RingWasRead : ClipError {
  RingWasRead() : ClipError("a service that read it crashed") {}
};

/// What an ImageRing left in its memory when its process crashed: frames and setups. Any of it may be
/// damaged: what is not as it must be is left out. Used by one thread.
///
/// Each memory can be looked at once, so that one whose reading crashes the service does not do so again.
class LeftRing {
 public:
  /// Throws RingWasRead, and ClipError for what is no such memory, was left by another version or ended well.
  explicit LeftRing(OpenFile file);
  /// Gives the memory back, also where others have it open, unless it was put back.
  ~LeftRing();
  /// Another process may read all of it, from its beginning.
  void put_back() noexcept;
  LeftRing(const LeftRing&) = delete;
  LeftRing& operator=(const LeftRing&) = delete;

  /// The oldest frame that was not dropped yet; null: there is none. Of an image in tiles the other tiles
  /// have no meaning.
  const ClipFrame* oldest();
  void drop_oldest();
  /// Whether a frame that came before the oldest, and after the last that was dropped, was damaged.
  bool lacks_one() const { return lacks_one_; }
  /// What all frames told together at the beginning, though some may turn out to be damaged.
  struct Extent {
    std::uint64_t frames = 0, bytes = 0;
    std::int64_t oldest_ns = 0, newest_ns = 0;  // when they arrived, on the steady clock
  };
  const Extent& extent() const { return extent_; }

  /// None: it is not there whole.
  std::optional<ClipSetup> setup(std::uint32_t number) const;

 private:
  const RingHead& head() const { return *reinterpret_cast<const RingHead*>(mapped_); }
  const RingSlot& slot(std::uint64_t frame) const {
    return reinterpret_cast<const RingSlot*>(mapped_ + kRingPage)[frame % kRingSlots];
  }
  bool may_be_there(std::uint64_t frame) const;
  void look() noexcept;

  OpenFile file_;
  std::size_t image_bytes_ = 0;
  std::byte* mapped_ = nullptr;
  std::uint64_t next_ = 0, end_ = 0;  // numbers of frames
  Extent extent_;
  bool has_oldest_ = false, lacks_one_ = false, is_put_back_ = false;
  ClipFrame oldest_;
  std::vector<std::byte> whole_;  // an image that is put together of tiles
};

}  // namespace sslv
