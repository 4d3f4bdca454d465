// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstddef>

namespace sslv {

/// Hands values from one thread, which must never wait, to another. Slots are reused and keep the memory that
/// their values reserved. When all slots are full, new values are dropped.
template <class T, std::size_t kSlots>
class SlotQueue {
 public:
  /// The slot to write the next value in; null when all are full. For the writer.
  T* to_write() noexcept {
    const std::size_t written = written_.load(std::memory_order_relaxed);
    if (written - read_.load(std::memory_order_acquire) >= kSlots) return nullptr;
    return &slots_[written % kSlots];
  }
  /// Hands the written slot over.
  void write() noexcept { written_.fetch_add(1, std::memory_order_release); }

  /// The oldest value that was handed over; null if there is none. For the reader.
  const T* to_read() const noexcept {
    const std::size_t read = read_.load(std::memory_order_relaxed);
    if (read == written_.load(std::memory_order_acquire)) return nullptr;
    return &slots_[read % kSlots];
  }
  /// Releases the slot returned by to_read().
  void read() noexcept { read_.fetch_add(1, std::memory_order_release); }

  /// Calls `prepare` for each slot. For the creating thread, before any other uses the queue.
  template <class Prepare>
  void prepare(const Prepare& prepare) {
    for (T& slot : slots_) prepare(slot);
  }

 private:
  std::array<T, kSlots> slots_{};
  std::atomic<std::size_t> written_{0}, read_{0};
};

}  // namespace sslv
