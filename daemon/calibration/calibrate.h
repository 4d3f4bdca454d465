// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/calibration_report.h"
#include "calibration/calibration_task.h"
#include "calibration/line_picture.h"

#include <stop_token>

namespace sslv {

/// Calibrates a camera from its image. Takes a few tenths of a second to 1 s; several seconds if nothing
/// fits. After a stop request, returns early with `found` false. Throws SettingsError if a click names an
/// unknown point, or if there are one or two clicks.
CalibrationReport calibrate(const MeanPicture& picture, const CalibrationTask& task,
                            const std::stop_token& stop = {});

}  // namespace sslv
