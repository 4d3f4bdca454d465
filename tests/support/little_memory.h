// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <fstream>
#include <functional>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace sslv::test {

/// Memory limit for reading a file, whatever it contains.
inline constexpr std::size_t kMemoryForAFile = 64'000'000;

/// Whether `act` succeeds with `bytes` more memory than this process has now; runs in a child process with
/// that limit. Does not work under a sanitizer, which reserves vast address space.
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
        ...) {  // std::bad_alloc; the test runner would catch it, and this child would run all other tests
      ::_exit(1);
    }
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace sslv::test
