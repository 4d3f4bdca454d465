// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <thread>

namespace sslv {

/// How many rows of an image are there, the first ones, while one thread still copies it and another one
/// already copies what is there further. The writer never waits.
class RowsThere {
 public:
  void set(int rows) noexcept { rows_.store(rows, std::memory_order_release); }
  /// A writer is in the middle of it: that is over too soon for sleeping.
  void wait_for(int rows) const noexcept {
    while (rows_.load(std::memory_order_acquire) < rows) std::this_thread::yield();
  }

 private:
  std::atomic<int> rows_{0};
};

}  // namespace sslv
