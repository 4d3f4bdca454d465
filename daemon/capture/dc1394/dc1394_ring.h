// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/dc1394/dc1394_camera.h"
#include "image/image.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace sslv::iidc {

/// The library's ring buffer of images, which are lent without copying. After close() the ring receives no
/// images, but keeps their memory and the camera open until the last lent image is released.
///
/// The library delivers images strictly by their position in the ring, regardless of the buffer that the card
/// has filled, so buffers must be returned in the order of delivery. A buffer released early waits for the
/// buffers before it, and an image held for a whole turn of the ring stops the camera.
class Ring : public std::enable_shared_from_this<Ring> {
 public:
  /// The camera must have been configured. Throws CaptureError.
  Ring(Handle handle, std::uint32_t frames, const std::string& label);
  ~Ring();
  Ring(const Ring&) = delete;
  Ring& operator=(const Ring&) = delete;

  /// Becomes readable when an image arrives.
  int fd() const { return fd_; }

  struct Taken {
    dc1394video_frame_t* frame = nullptr;  // null: no image has arrived
    dc1394error_t error = DC1394_SUCCESS;
    double queued_at_s = 0;  // Unix time at which the frame's buffer was queued for the card; 0: at the start
  };
  /// The next image that has arrived. Does not wait. Each frame must be passed to lend() or put_back().
  Taken take() noexcept;
  /// Allocates nothing. The view must refer to the frame's memory.
  Image lend(dc1394video_frame_t* frame, const ImageView& view) noexcept;
  void put_back(const dc1394video_frame_t* frame) noexcept;
  bool is_corrupt(dc1394video_frame_t* frame) noexcept;

  /// Call when the source ends: buffers can still be returned, but are not queued again.
  void close() noexcept;

 private:
  struct Slot {
    dc1394video_frame_t* frame = nullptr;
    std::shared_ptr<Ring> keeps{};  // set while lent
    bool returned = false;          // released, but older slots must be returned first
    double queued_at_s = 0;         // see Taken::queued_at_s
  };
  static void give_back(void* ring, void* slot) noexcept;
  void put_back(Slot& slot) noexcept;
  void set_up(std::uint32_t frames, const std::string& label);

  const Handle handle_;
  int fd_ = -1;

  std::mutex mutex_;  // guards the following members and the library's ring; held for one fast system call
  std::vector<Slot> slots_;
  std::vector<Slot*> out_;  // ring buffer of the taken slots; the oldest is at first_out_
  std::size_t first_out_ = 0, out_count_ = 0;
  dc1394error_t broken_ = DC1394_SUCCESS;  // why buffers cannot be queued
  bool closed_ = false, lingers_ = false;

  // Memory of the library's buffers; known from the first image on.
  unsigned char* memory_ = nullptr;
  std::size_t memory_bytes_ = 0;
};

}  // namespace sslv::iidc
