// SPDX-License-Identifier: Apache-2.0
#include "base/memory.h"

#include <atomic>

#include <malloc.h>

namespace sslv {
namespace {

constexpr int kTimes = 2;  // memory still in use at the first call may be free at the second
std::atomic<int> times_left{0};

}  // namespace

void memory_was_used() noexcept {
  times_left = kTimes;
}

void give_memory_back() noexcept {
  int left = times_left;
  // A concurrent call of memory_was_used() wins.
  if (left > 0 && times_left.compare_exchange_strong(left, left - 1)) malloc_trim(0);
}

}  // namespace sslv
