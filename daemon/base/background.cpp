// SPDX-License-Identifier: Apache-2.0
#include "base/background.h"

#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>

namespace sslv {

void become_background_thread(const char* name, int nice) {
  pthread_setname_np(pthread_self(), name);
  const sched_param none{};
  sched_setscheduler(0, SCHED_OTHER, &none);  // a real-time camera's thread may have started it
  // On Linux 0 means the calling thread, not the process. Lowering it needs no privilege, so it cannot fail.
  setpriority(PRIO_PROCESS, 0, nice);
}

void become_background_thread(const char* name) {
  constexpr int kNice = 10;
  become_background_thread(name, kNice);
}

void become_idle_thread(const char* name) {
  pthread_setname_np(pthread_self(), name);
  const sched_param none{};
  sched_setscheduler(0, SCHED_IDLE, &none);  // needs no privilege either
}

}  // namespace sslv
