// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace sslv {

/// Whether this build counts allocations; not under a sanitizer, which has its own allocator.
bool counts_allocations();

/// Number of calls of operator new by this thread so far, including libraries.
std::uint64_t allocation_count();

}  // namespace sslv
