// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sslv {

/// The last 512 durations of something, written by one thread without a lock, read by any.
class RecentDurations {
 public:
  struct Percentiles {
    double p50_us = 0, p99_us = 0;
  };

  void add_ns(std::int64_t duration_ns) noexcept {
    const std::uint64_t n = count_.load(std::memory_order_relaxed);
    samples_ns_[n % kCapacity].store(duration_ns, std::memory_order_relaxed);
    count_.store(n + 1, std::memory_order_release);
  }

  /// Zeros before the first sample.
  Percentiles percentiles() const {
    const std::uint64_t n = std::min<std::uint64_t>(count_.load(std::memory_order_acquire), kCapacity);
    if (n == 0) return {};
    std::vector<std::int64_t> sorted(n);
    for (std::size_t i = 0; i < n; ++i) sorted[i] = samples_ns_[i].load(std::memory_order_relaxed);
    std::sort(sorted.begin(), sorted.end());
    const auto at = [&](std::size_t percent) {
      return static_cast<double>(sorted[std::min<std::size_t>(n - 1, n * percent / 100)]) * 1e-3;
    };
    return {at(50), at(99)};
  }

 private:
  static constexpr std::size_t kCapacity = 512;
  std::array<std::atomic<std::int64_t>, kCapacity> samples_ns_{};
  std::atomic<std::uint64_t> count_{0};
};

}  // namespace sslv
