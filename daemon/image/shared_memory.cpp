// SPDX-License-Identifier: Apache-2.0
#include "image/shared_memory.h"

#include <array>
#include <atomic>
#include <cerrno>
#include <mutex>
#include <system_error>

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#ifndef F_SEAL_FUTURE_WRITE
#define F_SEAL_FUTURE_WRITE 0x0010  // <linux/fcntl.h> conflicts with <fcntl.h>
#endif

namespace sslv {
namespace {

/// Describes one SharedMemory. Written with a lock held, read without a lock: `id` is 0 during a change and
/// is never reused, so a reader that finds the same id before and after reading has read a consistent row.
struct Row {
  std::atomic<std::uint64_t> id{0};
  std::atomic<const std::uint8_t*> begin{nullptr};
  std::atomic<std::size_t> bytes{0};
  std::atomic<int> file{-1};
};

/// More than the number of image pools; each camera has one or two.
constexpr std::size_t kMaxRows = 64;
std::array<Row, kMaxRows> rows;
std::mutex rows_mutex;
std::atomic<std::uint64_t> made{0};
std::atomic<bool> is_wanted{false};

void add_row(const SharedMemory& memory) {
  const std::lock_guard lock(rows_mutex);
  for (Row& row : rows) {
    if (row.id.load() != 0) continue;
    row.begin.store(memory.data());
    row.bytes.store(memory.size());
    row.file.store(memory.file());
    row.id.store(memory.id());
    return;
  }
}

void remove_row(std::uint64_t id) {
  const std::lock_guard lock(rows_mutex);
  for (Row& row : rows) {
    if (row.id.load() == id) row.id.store(0);
  }
}

[[noreturn]] void fail(const char* what) {
  throw std::system_error(errno, std::system_category(), what);
}

}  // namespace

SharedMemory::SharedMemory(std::size_t bytes) : bytes_(bytes), id_(++made) {
  file_ = ::memfd_create("ssl-visiond", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (file_ < 0) fail("memfd_create");
  void* place = MAP_FAILED;
  if (::ftruncate(file_, static_cast<off_t>(bytes)) == 0)
    place = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file_, 0);
  if (place == MAP_FAILED ||
      ::fcntl(file_, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_FUTURE_WRITE | F_SEAL_SEAL) != 0) {
    const int error = errno;
    if (place != MAP_FAILED) ::munmap(place, bytes);
    ::close(file_);
    errno = error;
    fail("shared memory");
  }
  data_ = static_cast<std::uint8_t*>(place);
  add_row(*this);
}

SharedMemory::~SharedMemory() {
  remove_row(id_);
  ::munmap(data_, bytes_);
  ::close(file_);
}

std::optional<SharedPlace> shared_place(const std::uint8_t* bytes, std::size_t count) noexcept {
  for (const Row& row : rows) {
    const std::uint64_t id = row.id.load();
    if (id == 0) continue;
    const std::uint8_t* const begin = row.begin.load();
    const std::size_t size = row.bytes.load();
    const SharedPlace place{id, row.file.load(), size, static_cast<std::size_t>(bytes - begin)};
    if (row.id.load() != id || bytes < begin || place.offset > size || count > size - place.offset) continue;
    return place;
  }
  return std::nullopt;
}

void share_new_images(bool share) {
  is_wanted.store(share);
}

bool new_images_are_shared() {
  return is_wanted.load();
}

}  // namespace sslv
