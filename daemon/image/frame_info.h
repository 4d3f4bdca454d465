// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

namespace sslv {

/// What is known about a frame besides its pixels.
struct FrameInfo {
  std::uint32_t camera_id = 0;
  std::uint32_t number = 0;                    // counts this camera's processed frames
  double t_capture_s = 0;                      // Unix time of the exposure on the host's clock
  std::optional<double> t_capture_camera_s{};  // the camera's own clock, when it has one
};

}  // namespace sslv
