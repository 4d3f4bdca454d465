// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/v4l2/v4l2_device.h"
#include "image/image.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <linux/videodev2.h>

namespace sslv {

/// The buffers that a device fills, in memory shared with the kernel. Releasing a lent Image, on any thread,
/// returns its buffer to the device. Images may outlive stop(), and keep the device open.
class V4l2Stream : public std::enable_shared_from_this<V4l2Stream> {
 public:
  /// Maps and queues `buffers` buffers and starts the device. `type` is the device's buffer type; images have
  /// one plane. Throws CaptureError, beginning with `label`.
  static std::shared_ptr<V4l2Stream> start(std::shared_ptr<V4l2Device> device, v4l2_buf_type type,
                                           int buffers, const std::string& label);
  ~V4l2Stream();
  V4l2Stream(const V4l2Stream&) = delete;
  V4l2Stream& operator=(const V4l2Stream&) = delete;

  /// Stops streaming and frees the device for another opening. May block on dead hardware.
  void stop() noexcept;

  /// A filled buffer.
  struct Filled {
    std::uint32_t index = 0, sequence = 0;
    std::uint32_t flags = 0;  // V4L2_BUF_FLAG_...
    timeval timestamp{};
    std::size_t offset = 0;           // start of the image
    std::size_t bytes = 0, most = 0;  // image size reported by the device; space after `offset`
  };

  /// Fetches a filled buffer, which must then be lent or given back. Returns 0, or the errno; EAGAIN: none is
  /// ready.
  int fetch(Filled& filled) noexcept;
  const std::uint8_t* bytes_of(const Filled& filled) const {
    return buffers_[filled.index].memory + filled.offset;
  }
  /// `layout` describes the image; its data may be null.
  Image lend(const Filled& filled, ImageView layout) noexcept;
  void give_back(const Filled& filled) noexcept { queue(filled.index); }

  /// Whether the device has at least one buffer to fill.
  bool can_deliver() const { return lent_ < buffers_.size(); }
  /// The errno with which the device refused a returned buffer, which is then lost; 0: no error.
  int queue_error() const { return queue_error_; }

 private:
  struct Buffer {
    std::uint8_t* memory = nullptr;
    std::size_t size = 0;
    std::uint32_t index = 0;
    std::shared_ptr<V4l2Stream> keeps{};  // set while lent, to keep the memory mapped
  };

  V4l2Stream(std::shared_ptr<V4l2Device> device, v4l2_buf_type type)
      : device_(std::move(device)), type_(type) {}
  void map_buffers(int wanted, const std::string& label);
  int queue(std::uint32_t index) noexcept;
  static void take_back(void* owner, void* lent) noexcept;

  const std::shared_ptr<V4l2Device> device_;
  const v4l2_buf_type type_;
  std::vector<Buffer> buffers_;
  std::atomic<bool> stopped_{false};
  std::atomic<std::size_t> lent_{0};
  std::atomic<int> queue_error_{0};
};

}  // namespace sslv
