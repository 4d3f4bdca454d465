// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geometry/camera_model.h"

#include <optional>

#include <Eigen/Core>

namespace sslv {

/// Second-order map between pixels and the plane z = height around one point. Within the size of a robot it
/// differs from the camera model by less than 0.01 mm, and it costs only a few multiplications.
struct PlanePatch {
  Eigen::Vector2d pixel;     // image of the point
  Eigen::Vector2d field_mm;  // the point
  // Displacement on the plane (mm) for a displacement of (du, dv) pixels:
  // x = xu du + xv dv + xuu du^2 + xuv du dv + xvv dv^2, y likewise.
  double xu, xv, xuu, xuv, xvv;
  double yu, yv, yuu, yuv, yvv;

  /// Converts a displacement in pixels to mm on the plane.
  Eigen::Vector2d to_plane(double du, double dv) const {
    return {du * (xu + xuu * du + xuv * dv) + dv * (xv + xvv * dv),
            du * (yu + yuu * du + yuv * dv) + dv * (yv + yvv * dv)};
  }
  /// Converts a displacement in mm on the plane to pixels.
  Eigen::Vector2d to_pixel(const Eigen::Vector2d& offset_mm) const;

  /// Mean size of a pixel here (mm): the square root of the area that a pixel covers.
  double mm_per_px() const;
};

/// Patch around a point of the plane; nothing if the camera does not see the plane there. The patch is
/// accurate up to `reach_mm` from the point.
std::optional<PlanePatch> plane_patch(const CameraModel& camera, const Eigen::Vector2d& field_mm,
                                      double height_mm, double reach_mm);

inline Eigen::Vector2d PlanePatch::to_pixel(const Eigen::Vector2d& offset_mm) const {
  const double per_det = 1 / (xu * yv - xv * yu);
  Eigen::Vector2d pixels = Eigen::Vector2d::Zero();
  Eigen::Vector2d rest = offset_mm;
  // Second-order terms are small: each iteration gains about three digits.
  for (int i = 0; i < 2; ++i) {
    pixels += Eigen::Vector2d(yv * rest.x() - xv * rest.y(), xu * rest.y() - yu * rest.x()) * per_det;
    rest = offset_mm - to_plane(pixels.x(), pixels.y());
  }
  return pixels;
}

}  // namespace sslv
