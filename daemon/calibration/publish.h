// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/lens_camera.h"
#include "geometry/camera_model.h"

#include <optional>

namespace sslv {

/// A camera as the protocol describes it: with one radial term.
struct Published {
  CameraCalibration calibration;
  double rms_mm = 0, worst_mm = 0;  // deviation from the camera, over the image at z = 0
};

/// Height of the robots' tops. Errors of cameras are reported at this height and on the floor.
inline constexpr double kRobotTopsMm = 150;

/// The calibration whose image of the floor and robots' tops is nearest to the image by `camera`; identical
/// to `camera` if k2 is 0. Its quaternion has the sign nearer to the previous quaternion: q and -q are the
/// same rotation.
Published publish(const LensCamera& camera, const std::optional<CameraCalibration>& previous = {});

}  // namespace sslv
