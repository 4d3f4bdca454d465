// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipeline/frame.h"

#include <atomic>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace sslv {

/// A shared hold on one frame of a ring. Copying and dropping counts, nothing else; when the last hold goes,
/// the driver gets its buffer back and the slot is free. The frame is read-only once it has been shared.
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
    Slot* slot = std::exchange(slot_, nullptr);
    if (!slot) return;
    if (slot->holds.fetch_sub(1, std::memory_order_acq_rel) != 1) return;
    slot->frame.image = Image();  // nobody else can reach the slot until `free` says so
    slot->free.store(true, std::memory_order_release);
  }

  explicit operator bool() const { return slot_ != nullptr; }
  Frame& operator*() const { return slot_->frame; }
  Frame* operator->() const { return &slot_->frame; }

 private:
  friend class FrameRing;
  struct Slot {
    Frame frame;
    std::atomic<int> holds{0};
    std::atomic<bool> free{true};
  };
  explicit FrameRef(Slot* slot) : slot_(slot) {
    slot_->free.store(false, std::memory_order_relaxed);
    slot_->holds.store(1, std::memory_order_relaxed);
  }
  Slot* slot_ = nullptr;
};

/// Preallocated frames of one camera. Must outlive its FrameRefs.
class FrameRing {
 public:
  explicit FrameRing(std::size_t slots) {
    for (std::size_t i = 0; i < slots; ++i) slots_.push_back(std::make_unique<FrameRef::Slot>());
  }

  /// A free frame, its lists still holding what they held before; empty when viewers hold all of them.
  /// One thread only.
  FrameRef acquire() {
    for (std::size_t tried = 0; tried < slots_.size(); ++tried) {
      next_ = (next_ + 1) % slots_.size();
      if (slots_[next_]->free.load(std::memory_order_acquire)) return FrameRef(slots_[next_].get());
    }
    return {};
  }

 private:
  std::vector<std::unique_ptr<FrameRef::Slot>> slots_;
  std::size_t next_ = 0;
};

}  // namespace sslv
