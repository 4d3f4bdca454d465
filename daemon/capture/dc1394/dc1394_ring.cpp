// SPDX-License-Identifier: Apache-2.0
#include "capture/dc1394/dc1394_ring.h"

#include "base/clock.h"
#include "capture/source.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

namespace sslv::iidc {
namespace {

/// Cameras that this process has closed while one of their images is still held. Their bus bandwidth is still
/// reserved, although they send nothing.
class Lingering {
 public:
  void add(std::uint64_t guid) {
    const std::lock_guard lock(mutex_);
    guids_.push_back(guid);
  }
  void remove(std::uint64_t guid) {
    const std::lock_guard lock(mutex_);
    guids_.erase(std::find(guids_.begin(), guids_.end(), guid));
  }
  bool has(std::uint64_t guid) {
    const std::lock_guard lock(mutex_);
    return std::find(guids_.begin(), guids_.end(), guid) != guids_.end();
  }

 private:
  std::mutex mutex_;
  std::vector<std::uint64_t> guids_;
};

Lingering& lingering() {
  static Lingering one;
  return one;
}

bool is_out_of_bandwidth(dc1394error_t error) {
  // The library reports missing bandwidth as a missing channel, because the kernel then grants neither.
  return error == DC1394_NO_BANDWIDTH || error == DC1394_NO_ISO_CHANNEL;
}

}  // namespace

Ring::Ring(Handle handle, std::uint32_t frames, const std::string& label)
    : handle_(std::move(handle)), slots_(frames), out_(frames) {
  set_up(frames, label);
  fd_ = dc1394_capture_get_fileno(handle_.camera.get());
}

void Ring::set_up(std::uint32_t frames, const std::string& label) {
  dc1394camera_t* const camera = handle_.camera.get();
  dc1394error_t error = dc1394_capture_setup(camera, frames, DC1394_CAPTURE_FLAGS_DEFAULT);
  // The camera may reuse the bandwidth that is still reserved for it.
  if (is_out_of_bandwidth(error) && lingering().has(camera->guid))
    error = dc1394_capture_setup(camera, frames, DC1394_CAPTURE_FLAGS_CHANNEL_ALLOC);
  if (is_out_of_bandwidth(error)) {
    throw CaptureError(fmt::format(
        "camera \"{}\": the bus has not enough bandwidth left for it; use a smaller part of the sensor, "
        "fewer images per second (packet_size_bytes for Format7), a higher iso_speed, or a separate card",
        label));
  }
  check(error, label, fmt::format("memory for {} images cannot be allocated", frames));
}

Ring::~Ring() {
  dc1394camera_t* const camera = handle_.camera.get();
  if (dc1394_capture_stop(camera) == DC1394_IOCTL_FAILURE) {
    // If the camera is gone, the library gives up and leaks the images' memory and file.
    ::close(fd_);
    if (memory_ != nullptr) ::munmap(memory_, memory_bytes_);
  }
  if (lingers_) lingering().remove(camera->guid);
}

Ring::Taken Ring::take() noexcept {
  const std::lock_guard lock(mutex_);
  if (broken_ != DC1394_SUCCESS) return {nullptr, broken_};
  Taken taken;
  dc1394video_frame_t* frame = nullptr;
  taken.error = dc1394_capture_dequeue(handle_.camera.get(), DC1394_CAPTURE_POLICY_POLL, &frame);
  if (taken.error != DC1394_SUCCESS || frame == nullptr) return taken;
  if (memory_ == nullptr) {
    memory_ = frame->image - frame->id * frame->total_bytes;
    memory_bytes_ = slots_.size() * frame->total_bytes;
  }
  Slot& slot = slots_[frame->id];
  slot.frame = frame;
  out_[(first_out_ + out_count_) % out_.size()] = &slot;
  ++out_count_;
  taken.frame = frame;
  taken.queued_at_s = slot.queued_at_s;
  return taken;
}

bool Ring::is_corrupt(dc1394video_frame_t* frame) noexcept {
  return dc1394_capture_is_frame_corrupt(handle_.camera.get(), frame) == DC1394_TRUE;
}

Image Ring::lend(dc1394video_frame_t* frame, const ImageView& view) noexcept {
  Slot& slot = slots_[frame->id];
  slot.keeps = shared_from_this();
  return {view, this, &slot, &give_back};
}

void Ring::give_back(void* ring, void* slot) noexcept {
  // May be the last reference to the ring: keeps the ring alive until the end of this function.
  const std::shared_ptr<Ring> keeps = std::move(static_cast<Slot*>(slot)->keeps);
  static_cast<Ring*>(ring)->put_back(*static_cast<Slot*>(slot));
}

void Ring::put_back(const dc1394video_frame_t* frame) noexcept {
  put_back(slots_[frame->id]);
}

void Ring::put_back(Slot& slot) noexcept {
  const std::lock_guard lock(mutex_);
  slot.returned = true;
  while (out_count_ > 0 && out_[first_out_]->returned) {
    Slot& oldest = *out_[first_out_];
    oldest.returned = false;
    first_out_ = (first_out_ + 1) % out_.size();
    --out_count_;
    if (closed_) continue;
    const dc1394error_t error = dc1394_capture_enqueue(handle_.camera.get(), oldest.frame);
    if (error != DC1394_SUCCESS) broken_ = error;
    oldest.queued_at_s = unix_time_s();
  }
}

void Ring::close() noexcept {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  lingers_ = out_count_ > 0;
  if (lingers_) lingering().add(handle_.camera->guid);
}

}  // namespace sslv::iidc
