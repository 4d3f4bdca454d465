// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/lens_camera.h"
#include "geometry/camera_model.h"
#include "geometry/field.h"

#include <optional>

namespace sslv {

/// A camera as the protocol describes it: with one radial term.
struct Published {
  CameraCalibration calibration;
  double rms_mm = 0, worst_mm = 0;  // deviation from the camera at z = 0, where it was fitted
};

/// Height of the robots' tops. Errors of cameras are reported at this height and on the floor.
inline constexpr double kRobotTopsMm = 150;

/// The calibration that best reproduces how `camera` projects the floor and the robots' tops; identical to
/// `camera` if k2 is 0. Fitted where the image shows this field and a metre around it; without a field, over
/// the whole image. Of q and -q, which are the same rotation, its quaternion is the one nearer to the
/// previous quaternion.
Published publish(const LensCamera& camera, const std::optional<CameraCalibration>& previous = {},
                  const std::optional<FieldSize>& field = {});

}  // namespace sslv
