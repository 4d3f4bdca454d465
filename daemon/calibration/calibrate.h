// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/calibration_report.h"
#include "calibration/calibration_task.h"
#include "calibration/line_picture.h"

#include <stop_token>

namespace sslv {

/// Calibrates a camera from its image, in a few tenths of a second to one; in several seconds when nothing
/// fits. `stop` ends it early, with nothing found. Throws SettingsError for clicks that name no point, or are
/// too few.
CalibrationReport calibrate(const MeanPicture& picture, const CalibrationTask& task,
                            const std::stop_token& stop = {});

}  // namespace sslv
