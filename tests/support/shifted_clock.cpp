// SPDX-License-Identifier: Apache-2.0
// Preloaded (LD_PRELOAD), it shifts the clock of one program but not the computer's: adds the nanoseconds in
// the file named by SSLV_CLOCK_FILE, which may change at any time, to the Unix time. As when a real clock is
// set, steady clocks are not affected.
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <ctime>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <unistd.h>

namespace {

constexpr std::int64_t kSecondNs = 1'000'000'000;

const volatile std::int64_t* open_offset() {
  static const std::int64_t kNone = 0;
  const char* name = std::getenv("SSLV_CLOCK_FILE");
  if (name == nullptr) return &kNone;
  const int file = ::open(name, O_RDONLY | O_CLOEXEC);
  void* memory = ::mmap(nullptr, sizeof(std::int64_t), PROT_READ, MAP_SHARED, file, 0);
  ::close(file);
  return memory == MAP_FAILED ? &kNone : static_cast<const volatile std::int64_t*>(memory);
}

/// Reads the clock by a system call, because this library replaces the C library's functions.
int shifted(clockid_t clock, timespec& time) {
  if (::syscall(SYS_clock_gettime, clock, &time) != 0) return -1;
  if (clock != CLOCK_REALTIME && clock != CLOCK_REALTIME_COARSE) return 0;
  static const volatile std::int64_t* const offset = open_offset();
  const std::int64_t all_ns = time.tv_sec * kSecondNs + time.tv_nsec + *offset;
  time = {all_ns / kSecondNs, all_ns % kSecondNs};
  return 0;
}

}  // namespace

extern "C" {

int clock_gettime(clockid_t clock, timespec* time) noexcept {
  return shifted(clock, *time);
}

int gettimeofday(timeval* __restrict time, void* __restrict) noexcept {
  timespec now{};
  if (shifted(CLOCK_REALTIME, now) != 0) return -1;
  *time = {now.tv_sec, now.tv_nsec / 1000};
  return 0;
}

time_t time(time_t* out) noexcept {
  timespec now{};
  if (shifted(CLOCK_REALTIME, now) != 0) return -1;
  if (out != nullptr) *out = now.tv_sec;
  return now.tv_sec;
}
}
