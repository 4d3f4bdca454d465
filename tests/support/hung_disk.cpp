// SPDX-License-Identifier: Apache-2.0
// Preloaded (LD_PRELOAD), it makes the disk of one folder hang for one program: while the file named by
// SSLV_HUNG_WHILE exists, calls on anything below the folder SSLV_HUNG_FOLDER do not return.
#include <cstdarg>
#include <cstdlib>
#include <cstring>
#include <ctime>

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace {

void wait_while_hung(const char* path) {
  const char* const folder = std::getenv("SSLV_HUNG_FOLDER");
  const char* const flag = std::getenv("SSLV_HUNG_WHILE");
  if (folder == nullptr || flag == nullptr || std::strncmp(path, folder, std::strlen(folder)) != 0) return;
  while (::syscall(SYS_faccessat, AT_FDCWD, flag, F_OK) == 0) {
    // Creates a file beside SSLV_HUNG_WHILE to show that a thread hangs.
    char told[4096] = "";
    std::strncat(std::strncpy(told, flag, sizeof told - 16), ".reached", 15);
    ::close(static_cast<int>(::syscall(SYS_openat, AT_FDCWD, told, O_CREAT | O_WRONLY, 0600)));
    const timespec pause{0, 10'000'000};
    ::nanosleep(&pause, nullptr);
  }
}

}  // namespace

extern "C" {

int access(const char* path, int how) noexcept {
  wait_while_hung(path);
  return static_cast<int>(::syscall(SYS_faccessat, AT_FDCWD, path, how));
}

int stat(const char* __restrict path, struct stat* __restrict out) noexcept {
  wait_while_hung(path);
  return static_cast<int>(::syscall(SYS_newfstatat, AT_FDCWD, path, out, 0));
}

int stat64(const char* __restrict path, struct stat64* __restrict out) noexcept {
  wait_while_hung(path);
  return static_cast<int>(::syscall(SYS_newfstatat, AT_FDCWD, path, out, 0));
}

int open(const char* path, int flags, ...) {
  std::va_list rest;
  va_start(rest, flags);
  const mode_t permissions = (flags & O_CREAT) != 0 ? va_arg(rest, mode_t) : 0;
  va_end(rest);
  wait_while_hung(path);
  return static_cast<int>(::syscall(SYS_openat, AT_FDCWD, path, flags, permissions));
}

}  // extern "C"
