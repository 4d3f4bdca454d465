// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <climits>
#include <cstdint>

#include <linux/futex.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

namespace sslv {

/// Whether the waiting and waking threads belong to this process, or to any process that shares the memory.
enum class FutexScope : std::uint8_t { kProcess, kShared };

/// Sleeps while `word` equals `value`, but not beyond `until`; may wake spuriously. Like std::atomic::wait,
/// but with a deadline (futex(2)).
inline void futex_wait(const std::atomic<std::uint32_t>& word, std::uint32_t value,
                       std::chrono::steady_clock::time_point until,
                       FutexScope scope = FutexScope::kProcess) noexcept {
  static_assert(sizeof word == sizeof(std::uint32_t) && std::atomic<std::uint32_t>::is_always_lock_free);
  const auto since_boot = std::chrono::duration_cast<std::chrono::nanoseconds>(until.time_since_epoch());
  if (since_boot.count() <= 0) return;
  constexpr std::int64_t kNsPerSecond = 1'000'000'000;
  // This operation takes an absolute time of CLOCK_MONOTONIC, which is the steady clock.
  const timespec deadline{since_boot.count() / kNsPerSecond, since_boot.count() % kNsPerSecond};
  const int operation = scope == FutexScope::kProcess ? FUTEX_WAIT_BITSET_PRIVATE : FUTEX_WAIT_BITSET;
  syscall(SYS_futex, &word, operation, value, &deadline, nullptr, FUTEX_BITSET_MATCH_ANY);
}

inline void futex_wake_all(const std::atomic<std::uint32_t>& word,
                           FutexScope scope = FutexScope::kProcess) noexcept {
  const int operation = scope == FutexScope::kProcess ? FUTEX_WAKE_PRIVATE : FUTEX_WAKE;
  syscall(SYS_futex, &word, operation, INT_MAX, nullptr, nullptr, 0);
}

/// Lets a thread wake others without ever blocking. ring() takes no lock, and makes no system call while
/// nobody waits. A waiting thread calls mark(), checks what has changed, then calls wait().
class Bell {
 public:
  /// Call after the change.
  void ring() noexcept {
    rings_.fetch_add(1);
    if (waiting_.load() != 0) futex_wake_all(rings_);
  }

  std::uint32_t mark() const noexcept { return rings_.load(); }
  /// Returns when ring() has been called since `mark`, or at `until`.
  void wait(std::uint32_t mark, std::chrono::steady_clock::time_point until) const noexcept {
    waiting_.fetch_add(1);
    futex_wait(rings_, mark, until);
    waiting_.fetch_sub(1);
  }

 private:
  std::atomic<std::uint32_t> rings_{0};
  mutable std::atomic<std::uint32_t> waiting_{0};
};

}  // namespace sslv
