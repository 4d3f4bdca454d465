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

/// Mailbox for the newest finished frame of one ring: a newer frame replaces an unread one. Each reader
/// remembers the version it saw last, so several readers can read the same frame. The camera's thread never
/// waits to store a frame: a reader, even an interrupted one, holds a frame but no lock.
class LatestFrame {
 public:
  struct Versioned {
    std::uint64_t version;
    FrameRef value;
  };

  /// `ring` must outlive this and have at most 256 slots.
  explicit LatestFrame(const FrameRing& ring) : ring_(ring) {}
  ~LatestFrame() { close(); }
  LatestFrame(const LatestFrame&) = delete;
  LatestFrame& operator=(const LatestFrame&) = delete;

  /// Stores `frame`, which must belong to the ring and not be empty. For the camera's thread.
  void put(FrameRef frame) noexcept {
    std::uint64_t before = newest_.load(std::memory_order_relaxed);
    if (before == kClosed) return;
    const std::uint64_t after = (++version_ << kPlaceBits) | frame.slot_->place;
    // Only close() can intervene.
    if (!newest_.compare_exchange_strong(before, after)) return;
    frame.slot_ = nullptr;  // the hold belongs to the mailbox now
    let_go(before);
    changed_.ring();
  }

  /// The newest frame, if there is one.
  std::optional<Versioned> peek() const { return newer_than(0); }

  /// Waits for a version newer than `seen` (0: any). Returns nothing on timeout or after close().
  std::optional<Versioned> wait_newer(std::uint64_t seen, std::chrono::milliseconds timeout) const {
    const auto until = std::chrono::steady_clock::now() + timeout;
    for (;;) {
      const std::uint32_t mark = changed_.mark();
      if (auto found = newer_than(seen)) return found;
      if (newest_.load() == kClosed || std::chrono::steady_clock::now() >= until) return std::nullopt;
      changed_.wait(mark, until);
    }
  }

  /// Wakes all readers; no reader waits afterwards. Releases the stored frame; frames stored later are
  /// released at once.
  void close() noexcept {
    let_go(newest_.exchange(kClosed));
    changed_.ring();
  }

 private:
  static constexpr int kPlaceBits = 8;
  static constexpr std::uint64_t kNothing = 0, kClosed = ~std::uint64_t{0};

  FrameRef::Slot& slot_in(std::uint64_t word) const { return *ring_.slots_[word & ((1U << kPlaceBits) - 1)]; }

  /// Releases the mailbox's own hold.
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
      // `word` is still the newest frame, so the slot was not replaced before it was held.
      if (newest_.load() == word) return Versioned{word >> kPlaceBits, std::move(frame)};
    }
  }

  const FrameRing& ring_;
  std::uint64_t version_ = 0;                    // used by the camera's thread only
  std::atomic<std::uint64_t> newest_{kNothing};  // version and slot index; the mailbox holds this slot
  Bell changed_;
};

}  // namespace sslv
