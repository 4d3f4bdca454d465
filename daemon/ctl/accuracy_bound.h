// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geometry/camera_model.h"
#include "image/image.h"
#include "vision/patterns.h"

#include <optional>
#include <span>

namespace sslv {

/// An image of whose robots the places are to be estimated.
struct BoundPicture {
  const ImageView& image;  // with its noise: how bright the dots are is read from it
  const CameraModel& camera;
  const PatternTable& patterns;
  double blur_px;      // of the lens, as the sigma of a Gaussian
  double noise_sigma;  // of each red, green and blue value, in 8-bit grey levels, before a YUV camera mixes
};

/// Where a robot's pattern lies.
struct BoundPose {
  double x_mm, y_mm, orientation_rad, height_mm;
};

/// The least root mean square errors that an unbiased estimate can have (Cramer and Rao).
struct RobotBound {
  double position_mm, orientation_rad;
};

/// The bound for one robot, from what all samples at its dots' edges say, as if all but its pose were known:
/// brightness and colour of dots and top, blur and noise, with what the noise of Y, U and V has in common.
/// Rounding counts as noise. The top's rim does not count: robots differ there. `moments`: its poses during
/// the exposure, evenly spread. Nothing when a dot is not in the image.
std::optional<RobotBound> robot_bound(const BoundPicture& picture, std::span<const BoundPose> moments);

}  // namespace sslv
