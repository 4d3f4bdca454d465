// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sslv {

/// Names the calling thread (at most 15 characters) and lowers its priority below the cameras' threads. Use
/// it for work that may wait.
void become_background_thread(const char* name);
/// Uses this nice value (nice(2)) instead of 10.
void become_background_thread(const char* name, int nice);

/// Names the calling thread and restricts it to idle processor time: any other thread preempts it
/// (SCHED_IDLE, sched(7)). Use it for work that may be delayed without harm.
void become_idle_thread(const char* name);

/// Call when the program is about to end: restores the normal priority of all its threads, as far as
/// permitted (RLIMIT_NICE, CAP_SYS_NICE), so that exiting does not wait for a thread that gets no processor
/// time.
void stop_yielding() noexcept;

}  // namespace sslv
