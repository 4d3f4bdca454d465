// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace sslv {

/// The stage that a thread is running, and its start time. Written by that thread without a lock, read by any
/// thread. Outlives the pipeline, which may be replaced while one of its stages hangs.
class StageMark {
 public:
  struct Reading {
    std::size_t stage;      // index in the stage table
    std::int64_t since_ns;  // start of the stage, steady_ns()
  };

  void begin(std::size_t stage, std::int64_t now_ns) noexcept {
    since_ns_.store(now_ns, std::memory_order_relaxed);
    stage_.store(static_cast<std::int64_t>(stage), std::memory_order_relaxed);
  }
  void end() noexcept { stage_.store(kNone, std::memory_order_relaxed); }

  /// Returns nothing between stages. While a stage begins, the time may still be the previous stage's; this
  /// is acceptable, because readers search for stages that have run for seconds.
  std::optional<Reading> read() const {
    const std::int64_t stage = stage_.load(std::memory_order_relaxed);
    if (stage == kNone) return std::nullopt;
    return Reading{static_cast<std::size_t>(stage), since_ns_.load(std::memory_order_relaxed)};
  }

 private:
  static constexpr std::int64_t kNone = -1;
  std::atomic<std::int64_t> stage_{kNone}, since_ns_{0};
};

}  // namespace sslv
