// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <fstream>
#include <functional>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace sslv::test {

/// Memory that a file may take, however it was made.
inline constexpr std::size_t kMemoryForAFile = 64'000'000;

/// Whether `act` can do with so many bytes of memory more than this process has now: in a process of its own,
/// which gets no more. Not under a sanitizer, whose memory is endless.
inline bool fits_into(std::size_t bytes, const std::function<void()>& act) {
  const pid_t child = ::fork();
  if (child == 0) {
    std::size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    const rlim_t limit = pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE)) + bytes;
    const rlimit limits{limit, limit};
    ::setrlimit(RLIMIT_AS, &limits);
    try {
      act();
    } catch (
        ...) {  // std::bad_alloc; left to the test's runner, this process would go on with all other tests
      ::_exit(1);
    }
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace sslv::test
