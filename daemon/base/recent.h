// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sslv {

/// Ring buffer of the last 512 durations, in ns. One thread adds durations without a lock; any thread reads.
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

  /// Number of durations added so far, including those that are overwritten.
  std::uint64_t count() const { return count_.load(std::memory_order_acquire); }

  /// The durations added after the first `seen` and not yet overwritten, in no particular order.
  std::vector<std::int64_t> samples_ns(std::uint64_t seen = 0) const {
    const std::uint64_t n = count();
    std::vector<std::int64_t> samples;
    for (std::uint64_t i = std::max(seen, n > kCapacity ? n - kCapacity : 0); i < n; ++i)
      samples.push_back(samples_ns_[i % kCapacity].load(std::memory_order_relaxed));
    return samples;
  }

  /// Percentiles of samples_ns(seen), in us. Zeros without samples.
  Percentiles percentiles(std::uint64_t seen = 0) const {
    std::vector<std::int64_t> sorted = samples_ns(seen);
    if (sorted.empty()) return {};
    std::sort(sorted.begin(), sorted.end());
    const auto at = [&](std::size_t percent) {
      return static_cast<double>(sorted[std::min(sorted.size() - 1, sorted.size() * percent / 100)]) * 1e-3;
    };
    return {at(50), at(99)};
  }

 private:
  static constexpr std::size_t kCapacity = 512;
  std::array<std::atomic<std::int64_t>, kCapacity> samples_ns_{};
  std::atomic<std::uint64_t> count_{0};
};

}  // namespace sslv
