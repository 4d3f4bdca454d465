// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/background_jobs.h"
#include "calibration/calibration_json.h"
#include "services/cameras/fresh_frames.h"

#include <chrono>
#include <optional>
#include <set>
#include <string>

namespace sslv {

struct CalibrationOrder {
  CalibrationRequest request;
  FieldSize field;
  std::optional<CameraCalibration> previous;
  std::string who;  // the client's address
  double time_s = 0;
};

/// Calibrates single cameras while they keep running. Keys are the cameras' ids.
using CalibrationJobs = BackgroundJobs<CalibrationOrder, CalibrationReport>;

CalibrationJobs make_calibration_jobs(WaitFrame wait_frame, std::chrono::milliseconds silence = kSilence);

/// Fails the jobs of cameras that were removed or whose view has changed.
void invalidate(CalibrationJobs& jobs, const std::set<int>& camera_ids);

}  // namespace sslv
