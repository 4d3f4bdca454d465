// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sslv {

/// Called by a thread that may wait: names it (at most 15 characters) and makes it yield to the
/// cameras' threads.
void become_background_thread(const char* name);
/// Likewise, but by so much (nice(2); others yield by 10).
void become_background_thread(const char* name, int nice);

/// Names the calling thread, and lets it run only while nothing else wants its processor: whatever else wakes
/// takes it at once. For what may slow down without harm (SCHED_IDLE, sched(7)).
void become_idle_thread(const char* name);

/// When the program is to end: from now on no thread of it yields to other programs, or the end would wait
/// for a thread that gets no processor beside busy ones. As far as permitted (RLIMIT_NICE, CAP_SYS_NICE).
void stop_yielding() noexcept;

}  // namespace sslv
