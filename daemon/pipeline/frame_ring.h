// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipeline/frame.h"

#include <atomic>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace sslv {

/// Reference-counted handle of one frame of a ring. Copying and releasing only change the count, on any
/// thread; the ring reuses frames that nobody holds. A frame is read-only once it has been shared.
class FrameRef {
 public:
  FrameRef() = default;
  FrameRef(const FrameRef& other) : slot_(other.slot_) {
    if (slot_) slot_->holds.fetch_add(1, std::memory_order_relaxed);
  }
  FrameRef(FrameRef&& other) noexcept : slot_(std::exchange(other.slot_, nullptr)) {}
  FrameRef& operator=(FrameRef other) noexcept {
    std::swap(slot_, other.slot_);
    return *this;
  }
  ~FrameRef() { reset(); }

  void reset() {
    if (Slot* slot = std::exchange(slot_, nullptr)) slot->holds.fetch_sub(1, std::memory_order_acq_rel);
  }

  explicit operator bool() const { return slot_ != nullptr; }
  Frame& operator*() const { return slot_->frame; }
  Frame* operator->() const { return &slot_->frame; }

 private:
  friend class FrameRing;
  friend class LatestFrame;
  struct Slot {
    Frame frame;
    std::atomic<int> holds{0};  // 0: only the ring's own thread may touch the slot
    std::size_t place = 0;      // index in the ring
  };
  explicit FrameRef(Slot* held) : slot_(held) {}
  Slot* slot_ = nullptr;
};

/// Preallocated frames of one camera. Must outlive its FrameRefs. Only the camera's thread uses it.
///
/// Giving an image's buffer back takes locks of the driver, which the camera's thread needs for its next
/// image. So only the camera's thread gives buffers back, never a viewer's thread.
class FrameRing {
 public:
  explicit FrameRing(std::size_t slots) {
    for (std::size_t i = 0; i < slots; ++i) {
      slots_.push_back(std::make_unique<FrameRef::Slot>());
      slots_.back()->place = i;
    }
  }

  /// A free frame whose lists still have their old content; empty if viewers hold all frames.
  FrameRef acquire() {
    for (std::size_t tried = 0; tried < slots_.size(); ++tried) {
      next_ = (next_ + 1) % slots_.size();
      FrameRef::Slot& slot = *slots_[next_];
      if (slot.holds.load(std::memory_order_acquire) != 0) continue;
      slot.frame.image = Image();
      slot.holds.store(1, std::memory_order_release);
      return FrameRef(&slot);
    }
    return {};
  }

  /// Gives the buffers of all frames that nobody holds back to the driver. Returns the number of held frames.
  std::size_t give_back() {
    std::size_t held = 0;
    for (const auto& slot : slots_) {
      if (slot->holds.load(std::memory_order_acquire) == 0) {
        slot->frame.image = Image();
      } else {
        ++held;
      }
    }
    return held;
  }

 private:
  friend class LatestFrame;
  std::vector<std::unique_ptr<FrameRef::Slot>> slots_;
  std::size_t next_ = 0;
};

}  // namespace sslv
