// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "support/patience.h"

#include <chrono>
#include <thread>

namespace sslv::test {

/// Polls until the condition holds; false on timeout (kPatience). Sleeps in between, as background threads of
/// the same ctest entry need the processor.
template <class IsSo>
bool becomes(const IsSo& is_so) {
  const auto until = std::chrono::steady_clock::now() + kPatience;
  while (!is_so()) {
    if (std::chrono::steady_clock::now() > until) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

}  // namespace sslv::test
