// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sslv {

/// Call after many small, short-lived allocations that together used much memory. The allocator keeps such
/// memory; give_memory_back() returns it to the system. From any thread; takes no lock.
void memory_was_used() noexcept;

/// Call once a second. If memory_was_used() was called since the last call, this call and the next return
/// free memory to the system. Blocks threads that allocate meanwhile, about 10 ms for 100 MB of free memory:
/// do not call it from a thread of low priority.
void give_memory_back() noexcept;

}  // namespace sslv
