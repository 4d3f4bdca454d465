// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sslv {

/// Call after using much memory briefly in many small allocations that are or will soon be free. The
/// allocator keeps such memory; give_memory_back() returns it to the system. From any thread; takes no lock.
void memory_was_used() noexcept;

/// Call once a second. Returns free memory to the system, in this call and the next, if memory_was_used() was
/// called since the last one. Blocks threads that allocate meanwhile, about 10 ms for 100 MB of free memory:
/// do not call it from a thread of low priority.
void give_memory_back() noexcept;

}  // namespace sslv
