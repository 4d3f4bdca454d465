// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geometry/camera_model.h"

#include <algorithm>
#include <optional>

#include <Eigen/Core>

namespace sslv {

/// A camera as calibration knows it: as CameraModel, with a second radial term, so that a lens which the
/// wire's one term cannot describe does not bend everything else. With undistorted and distorted radius in
/// units of the focal length: undistorted = distorted (1 + k1 distorted^2 + k2 distorted^4) (Brown 1971).
struct LensCamera {
  int width = 0, height = 0;  // px
  double focal_px = 1, center_x = 0, center_y = 0, k1 = 0, k2 = 0;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // field to camera
  Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();

  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& point_mm) const;
  std::optional<Eigen::Vector2d> unproject(const Eigen::Vector2d& pixel, double height_mm) const;
  /// Whether a pixel is in the image, `margin_px` or more from its edge.
  bool is_in_picture(const Eigen::Vector2d& pixel, double margin_px = 0) const;
  /// On the floor below the camera.
  double px_per_mm() const { return focal_px / std::max(1.0, position_mm.z()); }
};

LensCamera lens_camera(const CameraCalibration& calibration);

/// Whether it looks down from where it sees 1.5 to 20 m across: fits of a wrong guess may end anywhere.
bool is_plausible(const LensCamera& camera);

/// What may change, in units of some like effect on the image. The first one changes the focal length by
/// exp(step) and with it the distance from the floor along the optical axis and the distortion: an image of
/// a plane hardly shows that, so that a solver sees a straight valley instead of a bent one.
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

/// The image of a point after a step, and its change by the step's parameters.
struct SteppedPixel {
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, kCameraParams> by_step;
};

/// A camera after a step that knows how its images change with it.
class SteppedCamera {
 public:
  SteppedCamera(const LensCamera& start, const CameraStep& step);

  const LensCamera& camera() const { return camera_; }
  std::optional<SteppedPixel> project(const Eigen::Vector3d& point_mm) const;
  /// Change of the camera's height above the floor, in mm, by the step's parameters.
  CameraStep height_by_step() const;
  /// Change of the radial terms.
  CameraStep k1_by_step() const;
  CameraStep k2_by_step() const;

 private:
  double k1_by_zoom() const;
  double k2_by_zoom() const;

  LensCamera start_, camera_;
  double grow_;                    // exp of the zoom
  Eigen::Vector3d along_axis_mm_;  // change of the position by the zoom
  Eigen::Matrix3d turn_by_step_;   // left Jacobian of the rotation
};

}  // namespace sslv
