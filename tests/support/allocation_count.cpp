// SPDX-License-Identifier: Apache-2.0
#include "allocation_count.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SSLV_OWN_NEW 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define SSLV_OWN_NEW 0
#endif
#endif
#ifndef SSLV_OWN_NEW
#define SSLV_OWN_NEW 1
#endif

#include <cstdlib>
#include <new>

namespace {
thread_local std::uint64_t count = 0;
}

#if SSLV_OWN_NEW
// The other forms of new and delete call these.
void* operator new(std::size_t size) {
  ++count;
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  ++count;
  const auto align = static_cast<std::size_t>(alignment);
  if (void* memory = std::aligned_alloc(align, (size + align - 1) / align * align)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}
#endif

namespace sslv {

bool counts_allocations() {
  return SSLV_OWN_NEW != 0;
}

std::uint64_t allocation_count() {
  return count;
}

}  // namespace sslv
