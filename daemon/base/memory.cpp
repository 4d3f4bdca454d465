// SPDX-License-Identifier: Apache-2.0
#include "base/memory.h"

#include <atomic>

#include <malloc.h>

namespace sslv {
namespace {

std::atomic<bool> was_used{false};

}  // namespace

void memory_was_used() noexcept {
  was_used = true;
}

void give_memory_back() noexcept {
  if (was_used.exchange(false)) malloc_trim(0);
}

}  // namespace sslv
