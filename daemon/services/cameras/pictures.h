// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"

#include <cstdint>
#include <memory>
#include <optional>

namespace sslv {

/// An image for viewing, on loan: release it soon.
struct LentPicture {
  std::shared_ptr<const void> hold;
  ImageView image;
  std::uint32_t frame_number = 0;
  double t_capture_s = 0;
};

/// Provides the images in which users click. Thread-safe.
class Pictures {
 public:
  virtual ~Pictures() = default;
  /// Returns the still with this number; without a number, the camera's newest frame. Throws HttpError 404 if
  /// there is no such still, 503 if there is no frame.
  virtual LentPicture look(int camera_id, std::optional<int> still) = 0;
};

}  // namespace sslv
