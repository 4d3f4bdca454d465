// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/futex.h"
#include "pipeline/frame_ring.h"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>
#include <utility>

namespace sslv {

/// A one-place mailbox for the finished frames of one ring: a newer one replaces an unread one. Every reader
/// keeps its own place by the version it saw last, so several may read the same frame. The camera's thread
/// puts them there and waits for nobody: no reader, wherever it is interrupted, holds anything but a frame.
class LatestFrame {
 public:
  struct Versioned {
    std::uint64_t version;
    FrameRef value;
  };

  /// `ring` must outlive this, and has no more than 256 slots.
  explicit LatestFrame(const FrameRing& ring) : ring_(ring) {}
  ~LatestFrame() { close(); }
  LatestFrame(const LatestFrame&) = delete;
  LatestFrame& operator=(const LatestFrame&) = delete;

  /// `frame` is of the ring and not empty. For the camera's thread.
  void put(FrameRef frame) noexcept {
    std::uint64_t before = newest_.load(std::memory_order_relaxed);
    if (before == kClosed) return;
    const std::uint64_t after = (++version_ << kPlaceBits) | frame.slot_->place;
    // Only close() may come between.
    if (!newest_.compare_exchange_strong(before, after)) return;
    frame.slot_ = nullptr;  // its hold is the mailbox's now
    let_go(before);
    changed_.ring();
  }

  /// The present frame if there is one.
  std::optional<Versioned> peek() const { return newer_than(0); }

  /// Waits for a version newer than `seen` (0: any). Nothing on timeout or after close().
  std::optional<Versioned> wait_newer(std::uint64_t seen, std::chrono::milliseconds timeout) const {
    const auto until = std::chrono::steady_clock::now() + timeout;
    for (;;) {
      const std::uint32_t mark = changed_.mark();
      if (auto found = newer_than(seen)) return found;
      if (newest_.load() == kClosed || std::chrono::steady_clock::now() >= until) return std::nullopt;
      changed_.wait(mark, until);
    }
  }

  /// Wakes all readers for good and lets go of the frame, and at once of every later one.
  void close() noexcept {
    let_go(newest_.exchange(kClosed));
    changed_.ring();
  }

 private:
  static constexpr int kPlaceBits = 8;
  static constexpr std::uint64_t kNothing = 0, kClosed = ~std::uint64_t{0};

  FrameRef::Slot& slot_in(std::uint64_t word) const { return *ring_.slots_[word & ((1U << kPlaceBits) - 1)]; }

  /// Of the mailbox's own hold.
  void let_go(std::uint64_t word) const {
    if (word != kNothing && word != kClosed) FrameRef(&slot_in(word)).reset();
  }

  std::optional<Versioned> newer_than(std::uint64_t seen) const {
    for (;;) {
      const std::uint64_t word = newest_.load();
      if (word == kClosed || word >> kPlaceBits <= seen) return std::nullopt;
      std::atomic<int>& holds = slot_in(word).holds;
      int held = holds.load(std::memory_order_relaxed);
      while (held != 0 && !holds.compare_exchange_weak(held, held + 1, std::memory_order_acq_rel)) {
      }
      if (held == 0) continue;  // replaced meanwhile, and free again
      FrameRef frame(&slot_in(word));
      // Not replaced when it was held: it is still the mailbox's, so it was that frame all the time.
      if (newest_.load() == word) return Versioned{word >> kPlaceBits, std::move(frame)};
    }
  }

  const FrameRing& ring_;
  std::uint64_t version_ = 0;                    // of the camera's thread
  std::atomic<std::uint64_t> newest_{kNothing};  // version and the slot's place, of which one hold is ours
  Bell changed_;
};

}  // namespace sslv
