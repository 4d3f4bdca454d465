// SPDX-License-Identifier: Apache-2.0
#pragma once

// Several cameras' calibration as JSON: what is asked for, and what came out.

#include "base/json.h"
#include "base/params.h"
#include "calibration/calibrate_jointly.h"

#include <tuple>
#include <vector>

namespace sslv {

struct JointCalibrationRequest {
  std::vector<int> cameras;
  int frames = 10;
  double seconds = 10;

  static constexpr auto fields() {
    using R = JointCalibrationRequest;
    return std::tuple{
        numbers("cameras", &R::cameras, 0, 255, "ids of the cameras; none: all that are calibrated"),
        number("frames", &R::frames, 1, 100, "", "images of each camera of which the mean is used"),
        number("seconds", &R::seconds, 0.0, 600.0, "s",
               "how long robots are looked for that two cameras see"),
    };
  }
};

/// The whole report, as docs/openapi.json has it.
Json report_json(const JointReport& report);

/// The figures of one camera that are worth keeping.
Json joint_figures_json(const JointReport& report, const JointCameraReport& camera);

}  // namespace sslv
