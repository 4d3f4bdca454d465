// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/calibration_task.h"
#include "calibration/lens_camera.h"

namespace sslv {

// Most fields look the same from both ends, so a camera's orientation must be known from other information.

/// Whether two cameras have the same orientation to within 60 deg.
bool same_way_round(const LensCamera& a, const LensCamera& b);

/// Whether +x is on the side that the task states; if it states none, on the side of the previous
/// calibration; without a previous calibration, to the right or upwards.
bool is_right_way_round(const LensCamera& camera, const CalibrationTask& task);

/// The camera rotated by 180 deg about the field's centre.
LensCamera turned_round(const LensCamera& camera);

/// Side of the image where +x is: "right", "left", "top" or "bottom".
const char* side_of_plus_x(const LensCamera& camera);

}  // namespace sslv
