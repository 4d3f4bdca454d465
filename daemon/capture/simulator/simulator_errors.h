// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"
#include "geometry/camera_model.h"

#include <tuple>

namespace sslv {

/// Errors of a simulated camera, like those of real cameras. Default: none.
struct SimulatorErrors {
  double moved_x_mm = 0, moved_y_mm = 0;
  double turned_deg = 0;
  double phase = 0;
  double time_offset_ms = 0, time_jitter_ms = 0;
  double drop_share = 0;

  static constexpr auto fields() {
    using E = SimulatorErrors;
    return std::tuple{
        number("moved_x_mm", &E::moved_x_mm, -1000.0, 1000.0, "mm",
               "distance along x between the camera's real and calibrated position"),
        number("moved_y_mm", &E::moved_y_mm, -1000.0, 1000.0, "mm", "distance along y"),
        number("turned_deg", &E::turned_deg, -10.0, 10.0, "deg",
               "rotation of the camera about the vertical, against its calibration"),
        number(
            "phase", &E::phase, 0.0, 1.0, "",
            "delay of the images behind those of other cameras, as a share of the time between two images"),
        number("time_offset_ms", &E::time_offset_ms, -1000.0, 1000.0, "ms",
               "delay of the time stamps behind the real capture times"),
        number("time_jitter_ms", &E::time_jitter_ms, 0.0, 100.0, "ms",
               "jitter of the time stamps (standard deviation)"),
        number("drop_share", &E::drop_share, 0.0, 1.0, "", "share of the images that are lost"),
    };
  }
};

/// The camera model with the camera's actual pose; `calibrated` has the assumed pose.
CameraModel with_errors(const CameraModel& calibrated, const SimulatorErrors& errors);

}  // namespace sslv
