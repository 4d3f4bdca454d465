// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <thread>
#include <type_traits>

namespace sslv {

/// A value that one thread writes often and any thread reads whole. The writer never waits; a reader that
/// meets a change reads again. So load() is for readers that are no more urgent than the writer: one that
/// keeps the writer off its processor waits in vain, and uses try_load(). (A sequence lock: Boehm, "Can
/// seqlocks get along with programming language memory models?", 2012.)
template <class T>
class Seqlock {
  static_assert(std::is_trivially_copyable_v<T>, "it is copied as bytes");

 public:
  Seqlock() { store(T{}); }

  /// One thread at a time.
  void store(const T& value) noexcept {
    std::array<std::uint64_t, kWords> copy{};
    std::memcpy(copy.data(), &value, sizeof value);
    const std::uint64_t sequence = sequence_.load(std::memory_order_relaxed);
    sequence_.store(sequence + 1, std::memory_order_relaxed);  // odd: being written
    for (std::size_t i = 0; i < kWords; ++i) words_[i].store(copy[i], std::memory_order_release);
    sequence_.store(sequence + 2, std::memory_order_release);
  }

  T load() const noexcept {
    T value;
    while (!try_load(value)) std::this_thread::yield();
    return value;
  }
  /// False while it is being written; `value` stays then.
  bool try_load(T& value) const noexcept {
    const std::uint64_t before = sequence_.load(std::memory_order_acquire);
    std::array<std::uint64_t, kWords> copy;
    for (std::size_t i = 0; i < kWords; ++i) copy[i] = words_[i].load(std::memory_order_acquire);
    if (before % 2 != 0 || sequence_.load(std::memory_order_relaxed) != before) return false;
    std::memcpy(static_cast<void*>(&value), copy.data(), sizeof value);
    return true;
  }

 private:
  static constexpr std::size_t kWords = (sizeof(T) + sizeof(std::uint64_t) - 1) / sizeof(std::uint64_t);
  std::array<std::atomic<std::uint64_t>, kWords> words_{};
  std::atomic<std::uint64_t> sequence_{0};
};

}  // namespace sslv
