// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

namespace sslv {

/// The times of an image.
struct CaptureTimes {
  double t_capture_s = 0;                      // Unix time of the middle of the exposure, on the host's clock
  std::optional<double> t_capture_camera_s{};  // the camera's own clock, when it has one
  /// Standard deviation of t_capture_s; none: only the image's arrival time is known.
  std::optional<double> t_capture_sigma_s{};
  bool is_by_ptp = false;       // the camera's clock and the host's follow the same master
  std::int64_t arrived_ns = 0;  // steady_ns() when the image was handed over; 0: not live
};

/// The full image that a frame is part of: the frame is a tile of a large camera's image, or a region read
/// from the sensor.
struct WholePicture {
  int width = 0, height = 0;  // px; 0: the frame is the full image
  int x = 0, y = 0;           // px; position of the frame's first pixel in the full image
};

/// Data of a frame besides its pixels.
struct FrameInfo {
  std::uint32_t camera_id = 0;
  std::uint32_t number = 0;  // counts this camera's processed frames
  CaptureTimes times{};
  WholePicture whole{};
};

}  // namespace sslv
