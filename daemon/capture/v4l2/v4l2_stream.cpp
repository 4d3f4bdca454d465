// SPDX-License-Identifier: Apache-2.0
#include "capture/v4l2/v4l2_stream.h"

#include "capture/source.h"

#include <algorithm>
#include <cerrno>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

/// A buffer for the kernel's calls. For a multi-planar device, it points to its own `plane` (always one plane
/// here), which has the image's size and position. So the object must not be moved.
struct KernelBuffer {
  KernelBuffer(v4l2_buf_type type, std::uint32_t index) {
    buffer.index = index;
    buffer.type = type;
    buffer.memory = V4L2_MEMORY_MMAP;
    if (type == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE) {
      buffer.length = 1;
      buffer.m.planes = &plane;
    }
  }
  KernelBuffer(const KernelBuffer&) = delete;
  KernelBuffer& operator=(const KernelBuffer&) = delete;

  bool is_planar() const { return buffer.type == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE; }
  std::size_t length() const { return is_planar() ? plane.length : buffer.length; }
  std::size_t bytes_used() const { return is_planar() ? plane.bytesused : buffer.bytesused; }
  /// Start of the image; bytes_used() counts from the start of the buffer.
  std::size_t data_offset() const { return is_planar() ? plane.data_offset : 0; }
  std::uint32_t map_offset() const { return is_planar() ? plane.m.mem_offset : buffer.m.offset; }

  v4l2_buffer buffer{};
  v4l2_plane plane{};
};

/// Requests `count` buffers and sets `count` to the number granted. Returns the errno, or 0.
int request_buffers(V4l2Device& device, v4l2_buf_type type, int& count) {
  v4l2_requestbuffers request{};
  request.count = static_cast<__u32>(count);
  request.type = type;
  request.memory = V4L2_MEMORY_MMAP;
  const int error = device.call(VIDIOC_REQBUFS, &request);
  count = static_cast<int>(request.count);
  return error;
}

}  // namespace

std::shared_ptr<V4l2Stream> V4l2Stream::start(std::shared_ptr<V4l2Device> device, v4l2_buf_type type,
                                              int buffers, const std::string& label) {
  std::shared_ptr<V4l2Stream> stream(new V4l2Stream(std::move(device), type));
  stream->map_buffers(buffers, label);
  int started = type;
  if (const int error = stream->device_->call(VIDIOC_STREAMON, &started); error != 0) {
    // The driver reports ENOSPC when another camera uses the bandwidth of the USB bus.
    throw CaptureError(
        fmt::format("camera \"{}\": does not start: {}", label,
                    error == ENOSPC ? "its USB bus has too little bandwidth left" : errno_text(error)));
  }
  return stream;
}

V4l2Stream::~V4l2Stream() {
  stop();
  for (const Buffer& buffer : buffers_) device_->unmap(buffer.memory, buffer.size);
}

void V4l2Stream::map_buffers(int wanted, const std::string& label) {
  const auto fail = [&](std::string_view what, int error) {
    throw CaptureError(fmt::format("camera \"{}\": {}: {}", label, what, errno_text(error)));
  };
  int count = wanted;
  if (const int error = request_buffers(*device_, type_, count); error == EBUSY) {
    throw CaptureError(fmt::format("camera \"{}\": another program uses it", label));
  } else if (error != 0) {
    fail("no buffers", error);
  }
  buffers_.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    KernelBuffer asked(type_, static_cast<std::uint32_t>(i));
    if (const int error = device_->call(VIDIOC_QUERYBUF, &asked.buffer); error != 0)
      fail("no buffers", error);
    std::uint8_t* memory = device_->map(asked.length(), asked.map_offset());
    if (memory == nullptr) fail("no buffers", errno);
    buffers_.push_back({memory, asked.length(), asked.buffer.index});
    if (const int error = queue(asked.buffer.index); error != 0) fail("its buffers cannot be queued", error);
  }
}

void V4l2Stream::stop() noexcept {
  if (stopped_.exchange(true)) return;
  int stopped = type_;
  device_->call(VIDIOC_STREAMOFF, &stopped);
  // Since Linux 4.20, lent buffers remain as orphans, which do not keep the device busy.
  int none = 0;
  request_buffers(*device_, type_, none);
}

int V4l2Stream::fetch(Filled& filled) noexcept {
  KernelBuffer fetched(type_, 0);
  if (const int error = device_->call(VIDIOC_DQBUF, &fetched.buffer); error != 0) return error;
  const v4l2_buffer& buffer = fetched.buffer;
  if (buffer.index >= buffers_.size()) return EIO;
  const std::size_t size = buffers_[buffer.index].size;
  filled = {buffer.index, buffer.sequence, buffer.flags, buffer.timestamp};
  filled.offset = std::min(fetched.data_offset(), size);
  filled.bytes = std::max(fetched.bytes_used(), filled.offset) - filled.offset;
  filled.most = size - filled.offset;
  return 0;
}

Image V4l2Stream::lend(const Filled& filled, ImageView layout) noexcept {
  Buffer& buffer = buffers_[filled.index];
  buffer.keeps = shared_from_this();
  ++lent_;
  layout.data = bytes_of(filled);
  return {layout, nullptr, &buffer, &take_back};
}

void V4l2Stream::take_back(void* /*owner*/, void* lent) noexcept {
  auto* buffer = static_cast<Buffer*>(lent);
  // Moved out first: once queued, the buffer may be lent again.
  const std::shared_ptr<V4l2Stream> stream = std::move(buffer->keeps);
  --stream->lent_;
  stream->queue(buffer->index);
}

int V4l2Stream::queue(std::uint32_t index) noexcept {
  if (stopped_) return 0;
  KernelBuffer buffer(type_, index);
  const int error = device_->call(VIDIOC_QBUF, &buffer.buffer);
  if (error != 0 && !stopped_) queue_error_ = error;
  return error;
}

}  // namespace sslv
