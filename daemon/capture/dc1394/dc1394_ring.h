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

/// The library's ring of images, lent out without a copy. Its memory goes with the last image that is
/// out, not with the source: until then the ring keeps the camera open, but takes nothing more.
///
/// The library hands images over strictly by their place in the ring, whichever buffer the card has filled:
/// buffers must come back to it in the order in which it gave them. So one that is returned early waits for
/// those before it, and an image that is held for as long as the ring is deep stops the camera.
class Ring : public std::enable_shared_from_this<Ring> {
 public:
  /// The camera must have been set up. Throws CaptureError.
  Ring(Handle handle, std::uint32_t frames, const std::string& label);
  ~Ring();
  Ring(const Ring&) = delete;
  Ring& operator=(const Ring&) = delete;

  /// Becomes readable when an image comes.
  int fd() const { return fd_; }

  struct Taken {
    dc1394video_frame_t* frame = nullptr;  // none: nothing has come
    dc1394error_t error = DC1394_SUCCESS;
    double queued_at_s = 0;  // Unix time since which the card could fill its buffer; 0: from the start
  };
  /// Does not wait. Each frame must be lent or put back.
  Taken take() noexcept;
  /// Allocates nothing. The view's memory is the frame's.
  Image lend(dc1394video_frame_t* frame, const ImageView& view) noexcept;
  void put_back(const dc1394video_frame_t* frame) noexcept;
  bool is_corrupt(dc1394video_frame_t* frame) noexcept;

  /// The source ends: what is out still comes back, but to nobody.
  void close() noexcept;

 private:
  struct Slot {
    dc1394video_frame_t* frame = nullptr;
    std::shared_ptr<Ring> keeps{};  // while lent
    bool returned = false;          // waits for older ones
    double queued_at_s = 0;         // see Taken
  };
  static void give_back(void* ring, void* slot) noexcept;
  void put_back(Slot& slot) noexcept;
  void set_up(std::uint32_t frames, const std::string& label);

  const Handle handle_;
  int fd_ = -1;

  std::mutex mutex_;  // guards what follows, and the library's ring; held for one quick system call
  std::vector<Slot> slots_;
  std::vector<Slot*> out_;  // a ring of those taken, the oldest at first_out_
  std::size_t first_out_ = 0, out_count_ = 0;
  dc1394error_t broken_ = DC1394_SUCCESS;  // why buffers cannot be given back
  bool closed_ = false, lingers_ = false;

  // Where the library has its buffers; known from the first image on.
  unsigned char* memory_ = nullptr;
  std::size_t memory_bytes_ = 0;
};

}  // namespace sslv::iidc
