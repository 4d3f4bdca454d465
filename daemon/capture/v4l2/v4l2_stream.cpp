// SPDX-License-Identifier: Apache-2.0
#include "capture/v4l2/v4l2_stream.h"

#include "capture/source.h"

#include <cerrno>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

v4l2_buffer empty_buffer(std::uint32_t index) {
  v4l2_buffer out{};
  out.index = index;
  out.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  out.memory = V4L2_MEMORY_MMAP;
  return out;
}

/// Returns how many there are now.
int request_buffers(V4l2Device& device, int& count) {
  v4l2_requestbuffers request{};
  request.count = static_cast<__u32>(count);
  request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  request.memory = V4L2_MEMORY_MMAP;
  const int error = device.call(VIDIOC_REQBUFS, &request);
  count = static_cast<int>(request.count);
  return error;
}

}  // namespace

std::shared_ptr<V4l2Stream> V4l2Stream::start(std::shared_ptr<V4l2Device> device, int buffers,
                                              const std::string& label) {
  std::shared_ptr<V4l2Stream> stream(new V4l2Stream(std::move(device)));
  stream->map_buffers(buffers, label);
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (const int error = stream->device_->call(VIDIOC_STREAMON, &type); error != 0) {
    // ENOSPC is how a USB bus says that another camera has taken its time.
    throw CaptureError(
        fmt::format("camera \"{}\": does not start: {}", label,
                    error == ENOSPC ? "too little is left of its USB bus" : errno_text(error)));
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
  if (const int error = request_buffers(*device_, count); error == EBUSY) {
    throw CaptureError(fmt::format("camera \"{}\": another program uses it", label));
  } else if (error != 0) {
    fail("no buffers", error);
  }
  buffers_.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    v4l2_buffer asked = empty_buffer(static_cast<std::uint32_t>(i));
    if (const int error = device_->call(VIDIOC_QUERYBUF, &asked); error != 0) fail("no buffers", error);
    std::uint8_t* memory = device_->map(asked.length, asked.m.offset);
    if (memory == nullptr) fail("no buffers", errno);
    buffers_.push_back({memory, asked.length, asked.index});
    if (const int error = queue(asked.index); error != 0) fail("does not take its buffers", error);
  }
}

void V4l2Stream::stop() noexcept {
  if (stopped_.exchange(true)) return;
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  device_->call(VIDIOC_STREAMOFF, &type);
  // Those that are still lent live on as orphans (Linux 4.20); nobody is kept from the device by them.
  int none = 0;
  request_buffers(*device_, none);
}

int V4l2Stream::fetch(v4l2_buffer& filled) noexcept {
  filled = empty_buffer(0);
  const int error = device_->call(VIDIOC_DQBUF, &filled);
  return error == 0 && filled.index >= buffers_.size() ? EIO : error;
}

Image V4l2Stream::lend(const v4l2_buffer& filled, ImageView layout) noexcept {
  Buffer& buffer = buffers_[filled.index];
  buffer.keeps = shared_from_this();
  ++lent_;
  layout.data = buffer.memory;
  return {layout, nullptr, &buffer, &take_back};
}

void V4l2Stream::take_back(void* /*owner*/, void* lent) noexcept {
  auto* buffer = static_cast<Buffer*>(lent);
  // Taken out first: once it is queued, the buffer may be lent again.
  const std::shared_ptr<V4l2Stream> stream = std::move(buffer->keeps);
  --stream->lent_;
  stream->queue(buffer->index);
}

int V4l2Stream::queue(std::uint32_t index) noexcept {
  if (stopped_) return 0;
  v4l2_buffer buffer = empty_buffer(index);
  const int error = device_->call(VIDIOC_QBUF, &buffer);
  if (error != 0 && !stopped_) queue_error_ = error;
  return error;
}

}  // namespace sslv
