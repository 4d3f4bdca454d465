// SPDX-License-Identifier: Apache-2.0
#pragma once

// Request and report of the joint calibration of several cameras as JSON.

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
        number("frames", &R::frames, 1, 100, "", "images to average per camera"),
        number("seconds", &R::seconds, 0.0, 600.0, "s", "time to search for robots that two cameras see"),
    };
  }
};

/// The whole report, as specified in docs/openapi.json.
Json report_json(const JointReport& report);

/// The figures that the history stores with one camera's calibration.
Json joint_figures_json(const JointReport& report, const JointCameraReport& camera);

}  // namespace sslv
