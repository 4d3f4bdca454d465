// SPDX-License-Identifier: Apache-2.0
#include "support/failing_disk.h"

#include <atomic>
#include <cerrno>

#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace {
std::atomic<bool> is_failing{false};
}

/// Replaces the C library's function.
extern "C" int fsync(int file) {
  struct stat status {};
  if (is_failing && ::fstat(file, &status) == 0 && S_ISDIR(status.st_mode)) {
    errno = EIO;
    return -1;
  }
  return static_cast<int>(::syscall(SYS_fsync, file));
}

namespace sslv::test {

FailingDisk::FailingDisk() {
  is_failing = true;
}

FailingDisk::~FailingDisk() {
  is_failing = false;
}

}  // namespace sslv::test
