// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/lens_camera.h"
#include "geometry/camera_model.h"

#include <optional>

namespace sslv {

/// What the wire can say of a camera, whose lens has but one radial term there.
struct Published {
  CameraCalibration calibration;
  double rms_mm = 0, worst_mm = 0;  // what it differs from the camera, over the image at z = 0
};

/// The height of robots' tops, about which the errors of cameras are told, as they are on the floor.
inline constexpr double kRobotTopsMm = 150;

/// The calibration that shows the floor and robots' tops nearest to where `camera` does: the same one when k2
/// is 0. Its quaternion has the sign that looks like the previous one's: q and -q are the same rotation.
Published publish(const LensCamera& camera, const std::optional<CameraCalibration>& previous = {});

}  // namespace sslv
