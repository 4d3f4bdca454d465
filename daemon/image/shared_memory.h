// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

namespace sslv {

/// Memory of a fixed size that another process can map, but only for reading (memfd_create(2),
/// F_SEAL_FUTURE_WRITE). Pages that are never touched take no physical memory.
class SharedMemory {
 public:
  /// Throws std::system_error if the system refuses.
  explicit SharedMemory(std::size_t bytes);
  ~SharedMemory();
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;

  std::uint8_t* data() const { return data_; }
  std::size_t size() const { return bytes_; }
  /// File descriptor to send to the reading process; valid as long as this object.
  int file() const { return file_; }
  /// Unique in this process; never 0.
  std::uint64_t id() const { return id_; }

 private:
  std::size_t bytes_;
  int file_ = -1;
  std::uint8_t* data_ = nullptr;
  std::uint64_t id_;
};

/// Position of bytes in memory that another process can read.
struct SharedPlace {
  std::uint64_t id = 0;  // SharedMemory::id()
  int file = -1;
  std::size_t memory_bytes = 0;  // size of the whole memory
  std::size_t offset = 0;        // start of the bytes in the memory
};

/// The SharedMemory of this process that contains all of the bytes. Nothing if there is no such memory, or if
/// it is not registered because too many SharedMemory objects exist (images are then copied). Takes no lock
/// and makes no system call. Valid as long as the caller holds the memory, as a camera's thread holds its
/// image.
std::optional<SharedPlace> shared_place(const std::uint8_t* bytes, std::size_t count) noexcept;

/// Sets whether image buffers created from now on are in memory that other processes can read. Initially off,
/// because no other process reads images.
void share_new_images(bool share);
bool new_images_are_shared();

}  // namespace sslv
