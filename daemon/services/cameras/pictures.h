// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"

#include <cstdint>
#include <memory>
#include <optional>

namespace sslv {

/// An image to look at, on loan: let go soon.
struct LentPicture {
  std::shared_ptr<const void> hold;
  ImageView image;
  std::uint32_t frame_number = 0;
  double t_capture_s = 0;
};

/// Images that a person points at. May be used from any thread.
class Pictures {
 public:
  virtual ~Pictures() = default;
  /// A still, or the camera's newest frame. Throws HttpError: 404 no such still, 503 no frame.
  virtual LentPicture look(int camera_id, std::optional<int> still) = 0;
};

}  // namespace sslv
