// SPDX-License-Identifier: Apache-2.0
#include "base/background.h"

#include <atomic>
#include <cstdlib>
#include <filesystem>

#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>

namespace sslv {
namespace {

std::atomic<bool> yields{true};

}  // namespace

void become_background_thread(const char* name, int nice) {
  pthread_setname_np(pthread_self(), name);
  const sched_param none{};
  sched_setscheduler(0, SCHED_OTHER, &none);  // the creating thread may be a camera's real-time thread
  if (!yields) return;
  // On Linux, 0 means the calling thread, not the process. Lowering a priority needs no privilege and cannot
  // fail.
  setpriority(PRIO_PROCESS, 0, nice);
}

void become_background_thread(const char* name) {
  constexpr int kNice = 10;
  become_background_thread(name, kNice);
}

void become_idle_thread(const char* name) {
  pthread_setname_np(pthread_self(), name);
  const sched_param none{};
  if (yields) sched_setscheduler(0, SCHED_IDLE, &none);  // needs no privilege either
}

void stop_yielding() noexcept {
  yields = false;
  std::error_code error;
  for (std::filesystem::directory_iterator task("/proc/self/task", error), end; !error && task != end;
       task.increment(error)) {
    const auto thread = static_cast<id_t>(std::atoi(task->path().filename().c_str()));
    const sched_param none{};
    if (sched_getscheduler(static_cast<pid_t>(thread)) == SCHED_IDLE)
      sched_setscheduler(static_cast<pid_t>(thread), SCHED_OTHER, &none);
    if (getpriority(PRIO_PROCESS, thread) > 0) setpriority(PRIO_PROCESS, thread, 0);
  }
}

}  // namespace sslv
