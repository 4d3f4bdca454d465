// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace sslv {

/// Histogram of durations since the start. Any thread can add without a lock; counts never decrease. The
/// buckets are fixed, so that counts from different years and computers can be added.
class DurationTotals {
 public:
  /// Inclusive upper bounds of the buckets; one more bucket holds all longer durations.
  static constexpr std::array<std::int64_t, 20> kEnds_ns{
      10'000,     25'000,     50'000,     100'000,     250'000,     500'000,      1'000'000,
      2'000'000,  3'000'000,  4'000'000,  5'000'000,   7'500'000,   10'000'000,   15'000'000,
      20'000'000, 30'000'000, 50'000'000, 100'000'000, 250'000'000, 1'000'000'000};

  struct Reading {
    std::array<std::uint64_t, kEnds_ns.size() + 1> counts{};
    std::uint64_t sum_ns = 0;
  };

  /// Negative durations, possible if a camera's clock is only estimated, count as 0.
  void add_ns(std::int64_t duration_ns) noexcept {
    duration_ns = std::max<std::int64_t>(duration_ns, 0);
    const auto bucket = std::lower_bound(kEnds_ns.begin(), kEnds_ns.end(), duration_ns) - kEnds_ns.begin();
    counts_[static_cast<std::size_t>(bucket)].fetch_add(1, std::memory_order_relaxed);
    sum_ns_.fetch_add(static_cast<std::uint64_t>(duration_ns), std::memory_order_relaxed);
  }

  Reading read() const {
    Reading out;
    for (std::size_t i = 0; i < counts_.size(); ++i)
      out.counts[i] = counts_[i].load(std::memory_order_relaxed);
    out.sum_ns = sum_ns_.load(std::memory_order_relaxed);
    return out;
  }

 private:
  std::array<std::atomic<std::uint64_t>, kEnds_ns.size() + 1> counts_{};
  std::atomic<std::uint64_t> sum_ns_{0};
};

}  // namespace sslv
