// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sslv {

/// Says that much memory was used for a moment, in many small pieces, and is free again or soon will be. The
/// allocator keeps such pieces; give_memory_back() hands them to the system. From any thread; takes no lock.
void memory_was_used() noexcept;

/// Once a second: hands free memory back to the system, this time and the next, if memory_was_used() was
/// called since the last time. Threads that allocate meanwhile wait, some 10 ms where 100 MB are free: not
/// for a thread of low priority.
void give_memory_back() noexcept;

}  // namespace sslv
