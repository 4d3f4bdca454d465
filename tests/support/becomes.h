// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "support/patience.h"

#include <chrono>
#include <thread>

namespace sslv::test {

/// Looks until it is so; false when it never is. Sleeps between two looks: background threads of the same
/// entry need the processor.
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
