// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/camera_clock.h"
#include "image/frame_info.h"

#include <optional>

namespace sslv {

/// The time information of an image, in seconds.
struct PictureStamps {
  double arrival_s = 0;              // Unix time when its first packet arrived: about the end of the exposure
  std::optional<double> camera_s{};  // start of the exposure on the camera's clock
  double exposure_s = 0;             // 0: unknown; impossible values count as unknown
  bool has_ptp = false;              // the camera has the Precision Time Protocol (IEEE 1588) enabled
};

/// Determines capture times for a camera with a clock: from that clock alone if both clocks follow PTP and
/// agree except for whole seconds; otherwise from the estimated clock offset once it is known; otherwise from
/// arrival times. No allocation. For one thread.
class PictureTimes {
 public:
  /// `now_s` (Unix time) and `steady_s` (steady clock) must be read at the same moment. The result's time is
  /// the middle of the exposure.
  CaptureTimes of(const PictureStamps& told, double now_s, double steady_s);

 private:
  bool follows_ptp(const PictureStamps& stamps, double& leap_s);

  CameraClock clock_;
  int ptp_pictures_ = 0;  // number of consecutive images in which the clocks agreed
};

}  // namespace sslv
