// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geometry/camera_model.h"
#include "image/image.h"
#include "vision/patterns.h"

#include <optional>
#include <span>

namespace sslv {

/// An image in which robots' poses are to be estimated.
struct BoundPicture {
  const ImageView& image;  // with its noise; the dots' contrast is measured in it
  const CameraModel& camera;
  const PatternTable& patterns;
  double blur_px;      // blur of the lens: sigma of a Gaussian
  double noise_sigma;  // noise of red, green or blue before conversion to YUV, in 8-bit grey levels
};

/// Pose of a robot's pattern.
struct BoundPose {
  double x_mm, y_mm, orientation_rad, height_mm;
};

/// Lower bounds (Cramer-Rao) of the root mean square errors of an unbiased estimate.
struct RobotBound {
  double position_mm, orientation_rad;
};

/// The bound for one robot from all samples at the edges of its dots, as if everything but its pose were
/// known: brightness and colour of dots and top, blur and noise, including the noise that Y, U and V share.
/// Rounding counts as noise. The top's rim is left out: robots differ there. `moments`: the robot's poses
/// during the exposure, evenly spaced. Nothing if a dot is outside the image.
std::optional<RobotBound> robot_bound(const BoundPicture& picture, std::span<const BoundPose> moments);

}  // namespace sslv
