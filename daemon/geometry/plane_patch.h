// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geometry/camera_model.h"

#include <optional>

#include <Eigen/Core>

namespace sslv {

/// The map from pixels to a plane z = height near one point of it, to second order: for what is as small as a
/// robot it differs from the camera model by less than 0.01 mm and costs a few multiplications.
struct PlanePatch {
  Eigen::Vector2d pixel;     // image of the point
  Eigen::Vector2d field_mm;  // the point
  // Displacement on the plane (mm) for one of (du, dv) pixels:
  // x = xu du + xv dv + xuu du^2 + xuv du dv + xvv dv^2, y likewise.
  double xu, xv, xuu, xuv, xvv;
  double yu, yv, yuu, yuv, yvv;

  /// Displacement on the plane for one in the image.
  Eigen::Vector2d to_plane(double du, double dv) const {
    return {du * (xu + xuu * du + xuv * dv) + dv * (xv + xvv * dv),
            du * (yu + yuu * du + yuv * dv) + dv * (yv + yvv * dv)};
  }
  /// Displacement in the image for one on the plane.
  Eigen::Vector2d to_pixel(const Eigen::Vector2d& offset_mm) const;

  /// Millimetres that a pixel measures here, both ways together: the root of the area it covers.
  double mm_per_px() const;
};

/// The patch around a point of the plane; nothing when the camera does not see the plane there. `reach_mm` is
/// how far from the point the patch is to be good.
std::optional<PlanePatch> plane_patch(const CameraModel& camera, const Eigen::Vector2d& field_mm,
                                      double height_mm, double reach_mm);

inline Eigen::Vector2d PlanePatch::to_pixel(const Eigen::Vector2d& offset_mm) const {
  const double per_det = 1 / (xu * yv - xv * yu);
  Eigen::Vector2d pixels = Eigen::Vector2d::Zero();
  Eigen::Vector2d rest = offset_mm;
  // The second order is small beside the first: each round gains some three digits.
  for (int i = 0; i < 2; ++i) {
    pixels += Eigen::Vector2d(yv * rest.x() - xv * rest.y(), xu * rest.y() - yu * rest.x()) * per_det;
    rest = offset_mm - to_plane(pixels.x(), pixels.y());
  }
  return pixels;
}

}  // namespace sslv
