// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/camera_clock.h"
#include "image/frame_info.h"

#include <optional>

namespace sslv {

/// What is known of an image's time, in seconds.
struct PictureStamps {
  double arrival_s = 0;              // Unix time at which its first packet came: about the exposure's end
  std::optional<double> camera_s{};  // the beginning of its exposure on the camera's own clock
  double exposure_s = 0;             // 0: not known; so is what no exposure can be
  bool has_ptp = false;              // the camera has the Precision Time Protocol (IEEE 1588) switched on
};

/// Says when the images of a camera with a clock were taken: from that clock alone, while it agrees with
/// the host's to whole seconds and both follow PTP; else from how it runs against arrivals, once that is
/// known; else from arrivals. No allocation. For one thread.
class PictureTimes {
 public:
  /// `now_s` and `steady_s`: Unix time and a steady clock, read at the same moment.
  CaptureTimes of(const PictureStamps& told, double now_s, double steady_s);

 private:
  bool follows_ptp(const PictureStamps& stamps, double& leap_s);

  CameraClock clock_;
  int ptp_pictures_ = 0;  // in a row that agree
};

}  // namespace sslv
