// SPDX-License-Identifier: Apache-2.0
#include "capture/v4l2/v4l2_device.h"

#include <cerrno>
#include <system_error>

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

namespace sslv {
namespace {

class KernelDevice final : public V4l2Device {
 public:
  explicit KernelDevice(int fd) : fd_(fd) {}
  ~KernelDevice() override { ::close(fd_); }

  int call(unsigned long request, void* argument) noexcept override {
    int result = 0;
    do {
      result = ::ioctl(fd_, request, argument);
    } while (result == -1 && errno == EINTR);
    return result == -1 ? errno : 0;
  }

  Ready wait(std::chrono::milliseconds timeout) noexcept override {
    pollfd polled{fd_, POLLIN | POLLPRI, 0};
    if (::poll(&polled, 1, static_cast<int>(timeout.count())) <= 0) return {};
    return {(polled.revents & POLLIN) != 0, (polled.revents & POLLPRI) != 0,
            (polled.revents & (POLLERR | POLLHUP | POLLNVAL)) != 0};
  }

  std::uint8_t* map(std::size_t bytes, std::uint32_t offset) noexcept override {
    void* memory =
        ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd_, static_cast<off_t>(offset));
    return memory == MAP_FAILED ? nullptr : static_cast<std::uint8_t*>(memory);
  }
  void unmap(std::uint8_t* memory, std::size_t bytes) noexcept override { ::munmap(memory, bytes); }

 private:
  const int fd_;
};

}  // namespace

std::shared_ptr<V4l2Device> open_v4l2_device(const std::string& path) {
  // Non-blocking: poll() waits for images, with a time limit.
  const int fd = ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  return fd < 0 ? nullptr : std::make_shared<KernelDevice>(fd);
}

std::string errno_text(int error) {
  return std::generic_category().message(error);
}

}  // namespace sslv
