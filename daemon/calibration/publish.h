// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/lens_camera.h"
#include "geometry/camera_model.h"

namespace sslv {

/// What the wire can say of a camera, whose lens has but one radial term there.
struct Published {
  CameraCalibration calibration;
  double rms_mm = 0, worst_mm = 0;  // what it differs from the camera, over the picture at z = 0
};

/// The calibration that shows the planes z = 0 and z = 150 mm nearest to where `camera` does: the same one
/// when k2 is 0.
Published publish(const LensCamera& camera);

}  // namespace sslv
