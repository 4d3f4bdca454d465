// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

namespace sslv {

/// The kernel's side of a video device, so that a test can play one. From any thread.
class V4l2Device {
 public:
  struct Ready {
    bool picture = false, event = false, error = false;
  };

  virtual ~V4l2Device() = default;

  /// ioctl(2), again when a signal interrupts it. 0, or the errno.
  virtual int call(unsigned long request, void* argument) noexcept = 0;
  /// Waits until there is something to fetch.
  virtual Ready wait(std::chrono::milliseconds timeout) noexcept = 0;
  /// Null, with errno, when it fails. What is mapped may be read until it is unmapped, whatever becomes of
  /// the device.
  virtual std::uint8_t* map(std::size_t bytes, std::uint32_t offset) noexcept = 0;
  virtual void unmap(std::uint8_t* memory, std::size_t bytes) noexcept = 0;
};

/// Opens a device node; the device is closed when the last hold on it goes. Null, with errno, when it cannot
/// be opened.
std::shared_ptr<V4l2Device> open_v4l2_device(const std::string& path);

/// The system's words for an errno.
std::string errno_text(int error);

}  // namespace sslv
