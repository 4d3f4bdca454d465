// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/calibration_task.h"
#include "calibration/lens_camera.h"

namespace sslv {

// Most fields look the same from both ends: which way round a camera sees one must be known from elsewhere.

/// Whether two cameras have +x on the same side.
bool same_way_round(const LensCamera& a, const LensCamera& b);

/// Whether a camera has +x where it should be, as far as the task says so: where it was said or was before,
/// else to the right or upwards.
bool is_right_way_round(const LensCamera& camera, const CalibrationTask& task);

/// The camera that sees the other half of the field just so.
LensCamera turned_round(const LensCamera& camera);

/// Side of the image where +x is: "right", "left", "top" or "bottom".
const char* side_of_plus_x(const LensCamera& camera);

}  // namespace sslv
