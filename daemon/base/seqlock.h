// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <thread>
#include <type_traits>

namespace sslv {

/// A value that one thread writes often and any thread reads consistently. The writer never waits; a reader
/// that overlaps a write retries (a sequence lock: Boehm, "Can seqlocks get along with programming language
/// memory models?", 2012). A reader of higher priority than the writer must not retry in a loop: see
/// try_load().
template <class T>
class Seqlock {
  static_assert(std::is_trivially_copyable_v<T>, "it is copied as bytes");

 public:
  Seqlock() { store(T{}); }

  /// Must be called by one thread at a time.
  void store(const T& value) noexcept {
    std::array<std::uint64_t, kWords> copy{};
    std::memcpy(copy.data(), &value, sizeof value);
    const std::uint64_t sequence = sequence_.load(std::memory_order_relaxed);
    sequence_.store(sequence + 1, std::memory_order_relaxed);  // odd: write in progress
    for (std::size_t i = 0; i < kWords; ++i) words_[i].store(copy[i], std::memory_order_release);
    sequence_.store(sequence + 2, std::memory_order_release);
  }

  T load() const noexcept {
    for (;; std::this_thread::yield()) {
      if (const auto value = try_load()) return *value;
    }
  }

  /// No value while a write is in progress.
  std::optional<T> try_load() const noexcept {
    const std::uint64_t before = sequence_.load(std::memory_order_acquire);
    std::array<std::uint64_t, kWords> copy;
    for (std::size_t i = 0; i < kWords; ++i) copy[i] = words_[i].load(std::memory_order_acquire);
    if (before % 2 != 0 || sequence_.load(std::memory_order_relaxed) != before) return std::nullopt;
    T value;
    std::memcpy(static_cast<void*>(&value), copy.data(), sizeof value);
    return value;
  }

 private:
  static constexpr std::size_t kWords = (sizeof(T) + sizeof(std::uint64_t) - 1) / sizeof(std::uint64_t);
  std::array<std::atomic<std::uint64_t>, kWords> words_{};
  std::atomic<std::uint64_t> sequence_{0};
};

}  // namespace sslv
