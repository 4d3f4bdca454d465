// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geometry/camera_model.h"
#include "services/health_report.h"

#include <optional>
#include <span>

namespace sslv {

/// State of a camera's calibration.
struct CalibrationFacts {
  int camera_id = 0;
  int width_px = 0, height_px = 0;  // size of its frames; 0: no frame yet
  std::optional<CameraCalibration> calibration;
  bool field_changed = false;  // the field was changed after the calibration
};

/// Adds the cameras' alerts and the check "calibration".
void report_calibrations(std::span<const CalibrationFacts> cameras, HealthReport& report);

}  // namespace sslv
