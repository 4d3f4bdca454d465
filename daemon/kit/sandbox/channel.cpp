// SPDX-License-Identifier: Apache-2.0
#include "kit/sandbox/channel.h"

#include <cerrno>
#include <new>
#include <numeric>
#include <system_error>

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#ifndef F_SEAL_FUTURE_WRITE
#define F_SEAL_FUTURE_WRITE 0x0010
#endif

namespace sslv::sandbox {
namespace {

constexpr std::size_t kHeader = 4096;
static_assert(sizeof(ToStage) <= kHeader && sizeof(FromStage) <= kHeader);
static_assert(std::atomic<std::uint32_t>::is_always_lock_free);

constexpr std::size_t constant_begin(std::size_t which) {
  std::size_t begin = kHeader;
  for (std::size_t i = 0; i < which; ++i) begin += kConstantRoom[i];
  return begin;
}
constexpr std::size_t kPartsBegin = constant_begin(kConstants), kImageBegin = kPartsBegin + kPartsRoom;
constexpr std::size_t kToBytes = kImageBegin + kImageRoom, kFromBytes = kHeader + kPartsRoom;

std::byte* map_channel(int file, std::size_t bytes, int protection) {
  void* place = ::mmap(nullptr, bytes, protection, MAP_SHARED, file, 0);
  if (place == MAP_FAILED) throw std::system_error(errno, std::system_category(), "mmap");
  return static_cast<std::byte*>(place);
}

int make_channel_file(std::size_t bytes) {
  const int file = ::memfd_create("ssl-visiond-stage", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (file < 0 || ::ftruncate(file, static_cast<off_t>(bytes)) != 0)
    throw std::system_error(errno, std::system_category(), "memfd_create");
  return file;
}

void seal(int file, int more) {
  // Access beyond the end of a shrunk file would raise SIGBUS in the service.
  if (::fcntl(file, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | more) != 0 ||
      ::fcntl(file, F_ADD_SEALS, F_SEAL_SEAL) != 0)
    throw std::system_error(errno, std::system_category(), "F_ADD_SEALS");
}

}  // namespace

Channel::Channel()
    : to_file_(make_channel_file(kToBytes)),
      from_file_(make_channel_file(kFromBytes)),
      to_(map_channel(to_file_, kToBytes, PROT_READ | PROT_WRITE)),
      from_(map_channel(from_file_, kFromBytes, PROT_READ | PROT_WRITE)) {
  seal(to_file_, F_SEAL_FUTURE_WRITE);
  seal(from_file_, 0);
  new (to_) ToStage;
  new (from_) FromStage;
}

Channel::Channel(int to_stage_file, int from_stage_file)
    : to_file_(to_stage_file),
      from_file_(from_stage_file),
      to_(map_channel(to_file_, kToBytes, PROT_READ)),
      from_(map_channel(from_file_, kFromBytes, PROT_READ | PROT_WRITE)) {}

Channel::~Channel() {
  ::munmap(to_, kToBytes);
  ::munmap(from_, kFromBytes);
  ::close(to_file_);
  ::close(from_file_);
}

std::span<std::byte> Channel::constant(Constant which) const {
  const auto i = static_cast<std::size_t>(which);
  return {to_ + constant_begin(i), kConstantRoom[i]};
}
std::span<std::byte> Channel::parts_to_stage() const {
  return {to_ + kPartsBegin, kPartsRoom};
}
std::span<std::byte> Channel::image() const {
  return {to_ + kImageBegin, kImageRoom};
}
std::span<std::byte> Channel::parts_from_stage() const {
  return {from_ + kHeader, kPartsRoom};
}

}  // namespace sslv::sandbox
