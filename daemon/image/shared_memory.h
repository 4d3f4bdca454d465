// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

namespace sslv {

/// Memory of a fixed size that another process may look at: only read, however it asks (memfd_create(2),
/// F_SEAL_FUTURE_WRITE). What is never touched takes no real memory.
class SharedMemory {
 public:
  /// Throws std::system_error when the system gives none.
  explicit SharedMemory(std::size_t bytes);
  ~SharedMemory();
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;

  std::uint8_t* data() const { return data_; }
  std::size_t size() const { return bytes_; }
  /// To be sent to who may look at it; valid as long as this.
  int file() const { return file_; }
  /// Another number for each in this process; never 0.
  std::uint64_t id() const { return id_; }

 private:
  std::size_t bytes_;
  int file_ = -1;
  std::uint8_t* data_ = nullptr;
  std::uint64_t id_;
};

/// Where bytes lie that another process may look at.
struct SharedPlace {
  std::uint64_t id = 0;  // SharedMemory::id()
  int file = -1;
  std::size_t memory_bytes = 0;  // of all of that memory
  std::size_t offset = 0;        // of the bytes in it
};

/// The SharedMemory of this process in which the bytes lie, all of them; nothing when there is none, or when
/// there are so many that it is not known (then images are copied, no more). Takes no lock and makes no
/// system call. The answer holds as long as who asks holds the memory, as a camera's thread holds the image
/// it asks for.
std::optional<SharedPlace> shared_place(const std::uint8_t* bytes, std::size_t count) noexcept;

/// Whether image buffers that are made from now on lie in such memory. At first they do not: nobody looks at
/// them.
void share_new_images(bool share);
bool new_images_are_shared();

}  // namespace sslv
