// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace sslv {

/// Whether allocations are counted in this build; not under a sanitizer, which has an allocator of its own.
bool counts_allocations();

/// Calls of operator new by this thread so far, libraries included.
std::uint64_t allocation_count();

}  // namespace sslv
