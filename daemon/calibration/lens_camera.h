// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geometry/camera_model.h"

#include <algorithm>
#include <optional>

#include <Eigen/Core>

namespace sslv {

/// CameraModel with a second radial term, so that a lens which the protocol's one term cannot describe does
/// not bias the other parameters. With radii in units of the focal length: undistorted = distorted (1 + k1
/// distorted^2 + k2 distorted^4) (Brown 1971).
struct LensCamera {
  int width = 0, height = 0;  // px
  double focal_px = 1, center_x = 0, center_y = 0, k1 = 0, k2 = 0;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // field to camera
  Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();

  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& point_mm) const;
  std::optional<Eigen::Vector2d> unproject(const Eigen::Vector2d& pixel, double height_mm) const;
  /// Whether a pixel is in the image, `margin_px` or more from its edge.
  bool is_in_picture(const Eigen::Vector2d& pixel, double margin_px = 0) const;
  /// Scale on the floor below the camera.
  double px_per_mm() const { return focal_px / std::max(1.0, position_mm.z()); }
};

LensCamera lens_camera(const CameraCalibration& calibration);

/// Whether the camera looks down and sees 1.5 to 20 m across. Fits from a wrong guess may converge anywhere.
bool is_plausible(const LensCamera& camera);

/// Parameters of a step, in units of similar effect on the image. kZoom scales the focal length by exp(step),
/// and adapts the distance from the floor along the optical axis and the distortion. The image of a plane
/// hardly changes with such a step, so that the cost has a straight valley instead of a curved one.
enum CameraParam {
  kZoom,
  kCenterX,  // px
  kCenterY,
  kK1,
  kK2,
  kTurnX,  // rad, about the camera's axes
  kTurnY,
  kTurnZ,
  kMoveX,  // m
  kMoveY,
  kMoveZ,
  kCameraParams
};
using CameraStep = Eigen::Matrix<double, kCameraParams, 1>;

/// `camera` after a step.
LensCamera moved(const LensCamera& camera, const CameraStep& step);

/// Pixel of a point after a step, and its Jacobian with respect to the step's parameters.
struct SteppedPixel {
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, kCameraParams> by_step;
};

/// A camera after a step, with derivatives with respect to the step's parameters.
class SteppedCamera {
 public:
  SteppedCamera(const LensCamera& start, const CameraStep& step);

  const LensCamera& camera() const { return camera_; }
  std::optional<SteppedPixel> project(const Eigen::Vector3d& point_mm) const;
  /// Derivative of the camera's height above the floor, in mm.
  CameraStep height_by_step() const;
  /// Derivatives of the radial terms.
  CameraStep k1_by_step() const;
  CameraStep k2_by_step() const;

 private:
  double k1_by_zoom() const;
  double k2_by_zoom() const;

  LensCamera start_, camera_;
  double grow_;                    // exp(kZoom)
  Eigen::Vector3d along_axis_mm_;  // derivative of the position with respect to kZoom
  Eigen::Matrix3d turn_by_step_;   // left Jacobian of the rotation
};

}  // namespace sslv
