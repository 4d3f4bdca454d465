// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <limits>

#include <sanitizer/allocator_interface.h>

namespace sslv {

/// Readers of files and packets must not use more memory at once, for any input.
inline constexpr std::int64_t kMaxLiveBytes = std::int64_t{64} << 20U;

/// Limits the memory that all threads have allocated and not freed while an input is read: from construction
/// to destruction. Beyond the limit it prints a message and aborts. libFuzzer's -malloc_limit_mb limits only
/// single allocations.
class LiveBytes {
 public:
  explicit LiveBytes(std::int64_t most) {
    before_ = live_.load();
    most_ = most;
  }
  ~LiveBytes() { most_ = kUnbounded; }
  LiveBytes(const LiveBytes&) = delete;
  LiveBytes& operator=(const LiveBytes&) = delete;

 private:
  static constexpr std::int64_t kUnbounded = std::numeric_limits<std::int64_t>::max();

  static std::int64_t size_of(const volatile void* memory) {
    // The sanitizer itself reports memory that it does not own, such as a double free.
    if (__sanitizer_get_ownership(memory) == 0) return 0;
    return static_cast<std::int64_t>(__sanitizer_get_allocated_size(memory));
  }
  static void allocated(const volatile void* memory, std::size_t /*size*/) {
    const std::int64_t now = live_ += size_of(memory), most = most_;
    if (now - before_ <= most) return;
    most_ = kUnbounded;  // the code below allocates too
    std::fprintf(stderr, "%lld bytes are allocated while one input is read; at most %lld may be\n",
                 static_cast<long long>(now - before_), static_cast<long long>(most));
    std::abort();
  }
  static void freed(const volatile void* memory) { live_ -= size_of(memory); }

  static inline std::atomic<std::int64_t> live_{0}, before_{0}, most_{kUnbounded};
  /// Initialised before there are threads.
  static inline const bool kIsInstalled = [] {
    if (__sanitizer_install_malloc_and_free_hooks(allocated, freed) != 0) return true;
    std::fprintf(stderr, "allocations cannot be counted\n");
    std::abort();
  }();
};

}  // namespace sslv
