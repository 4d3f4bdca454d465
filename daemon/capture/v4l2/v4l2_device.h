// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

namespace sslv {

/// The kernel's interface to a video device, which tests can replace. Thread-safe.
class V4l2Device {
 public:
  struct Ready {
    bool picture = false, event = false, error = false;
  };

  virtual ~V4l2Device() = default;

  /// ioctl(2), repeated after interruption by a signal. Returns 0, or the errno.
  virtual int call(unsigned long request, void* argument) noexcept = 0;
  /// Waits until an image or an event can be fetched.
  virtual Ready wait(std::chrono::milliseconds timeout) noexcept = 0;
  /// Null, with errno, on failure. The memory stays readable until it is unmapped, even if the device is
  /// removed.
  virtual std::uint8_t* map(std::size_t bytes, std::uint32_t offset) noexcept = 0;
  virtual void unmap(std::uint8_t* memory, std::size_t bytes) noexcept = 0;
};

/// Opens a device node, which is closed when the last reference is released. Null, with errno, on failure.
std::shared_ptr<V4l2Device> open_v4l2_device(const std::string& path);

/// The system's text for an errno.
std::string errno_text(int error);

}  // namespace sslv
