// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

namespace sslv {

/// When an image was taken.
struct CaptureTimes {
  double t_capture_s = 0;                      // Unix time of the middle of the exposure, on the host's clock
  std::optional<double> t_capture_camera_s{};  // the camera's own clock, when it has one
  /// Standard deviation of t_capture_s; none: nothing but the image's arrival is known.
  std::optional<double> t_capture_sigma_s{};
  bool is_by_ptp = false;       // the camera's clock and the host's follow the same master
  std::int64_t arrived_ns = 0;  // steady_ns() when the image was handed over; 0: not live
};

/// The larger image that an image is a part of: a big camera's, of which it is a tile, or the whole
/// sensor's, of which a part is read.
struct WholePicture {
  int width = 0, height = 0;  // px; 0: it is whole itself
  int x = 0, y = 0;           // of the part's first pixel in it
};

/// What is known about a frame besides its pixels.
struct FrameInfo {
  std::uint32_t camera_id = 0;
  std::uint32_t number = 0;  // counts this camera's processed frames
  CaptureTimes times{};
  WholePicture whole{};
};

}  // namespace sslv
