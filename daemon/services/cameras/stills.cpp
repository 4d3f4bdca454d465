// SPDX-License-Identifier: Apache-2.0
#include "services/cameras/stills.h"

#include <algorithm>
#include <utility>

namespace sslv {

StillPicture::StillPicture(const ImageView& image, std::uint32_t frame, double t_capture)
    : view(image), frame_number(frame), t_capture_s(t_capture) {
  const auto row_bytes = static_cast<std::ptrdiff_t>(image.width) * bytes_per_pixel(image.format);
  bytes.reserve(static_cast<std::size_t>(row_bytes * image.height));
  for (int y = 0; y < image.height; ++y) bytes.insert(bytes.end(), image.row(y), image.row(y) + row_bytes);
  view.data = bytes.data();
  view.stride_bytes = row_bytes;
}

int Stills::keep(int camera_id, StillPicture picture, Clock::time_point now) {
  auto shared = std::make_shared<StillPicture>(std::move(picture));
  shared->view.data = shared->bytes.data();
  const std::lock_guard lock(mutex_);
  forget_old_locked(now);
  auto& of_camera = stills_[camera_id];
  of_camera.push_back({++newest_, now, std::move(shared)});
  if (of_camera.size() > kMaxOfACamera) of_camera.pop_front();
  return newest_;
}

std::shared_ptr<const StillPicture> Stills::find(int camera_id, int number, Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  forget_old_locked(now);
  const auto of_camera = stills_.find(camera_id);
  if (of_camera == stills_.end()) return nullptr;
  for (Still& still : of_camera->second) {
    if (still.number != number) continue;
    still.asked = now;
    return still.picture;
  }
  return nullptr;
}

void Stills::forget_old(Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  forget_old_locked(now);
}

void Stills::forget_old_locked(Clock::time_point now) {
  for (auto& [camera, of_camera] : stills_) {
    std::erase_if(of_camera, [now](const Still& still) { return now - still.asked > kLongest; });
  }
  std::erase_if(stills_, [](const auto& entry) { return entry.second.empty(); });
}

}  // namespace sslv
