// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <thread>

namespace sslv {

/// Number of leading rows that are available while one thread still copies an image and another already reads
/// them. The writer never waits.
class RowsThere {
 public:
  void set(int rows) noexcept { rows_.store(rows, std::memory_order_release); }
  /// Spins: the writer is already copying and finishes too soon for sleeping to pay off.
  void wait_for(int rows) const noexcept {
    while (rows_.load(std::memory_order_acquire) < rows) std::this_thread::yield();
  }

 private:
  std::atomic<int> rows_{0};
};

}  // namespace sslv
