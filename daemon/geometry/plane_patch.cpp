// SPDX-License-Identifier: Apache-2.0
#include "geometry/plane_patch.h"

#include <cmath>

namespace sslv {

Eigen::Vector2d PlanePatch::to_pixel(const Eigen::Vector2d& offset_mm) const {
  const double det = xu * yv - xv * yu;
  Eigen::Vector2d pixels = Eigen::Vector2d::Zero();
  Eigen::Vector2d rest = offset_mm;
  // The second order is small beside the first: each round gains some three digits.
  for (int i = 0; i < 2; ++i) {
    pixels += Eigen::Vector2d(yv * rest.x() - xv * rest.y(), xu * rest.y() - yu * rest.x()) / det;
    rest = offset_mm - to_plane(pixels.x(), pixels.y());
  }
  return pixels;
}

double PlanePatch::mm_per_px() const {
  return std::sqrt(std::abs(xu * yv - xv * yu));
}

std::optional<PlanePatch> plane_patch(const CameraModel& camera, const Eigen::Vector2d& field_mm,
                                      double height_mm, double reach_mm) {
  const auto pixel = camera.project({field_mm.x(), field_mm.y(), height_mm});
  if (!pixel) return std::nullopt;
  const double area = camera.mm2_per_px(*pixel, height_mm);
  if (!(area > 0)) return std::nullopt;
  // Differences over half the reach spread the error evenly over the patch.
  const double e = 0.5 * reach_mm / std::sqrt(area);
  Eigen::Vector2d at[3][3];
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) {
      const auto p = camera.unproject(*pixel + Eigen::Vector2d((i - 1) * e, (j - 1) * e), height_mm);
      if (!p) return std::nullopt;
      at[j][i] = *p;
    }
  }
  const Eigen::Vector2d u = (at[1][2] - at[1][0]) / (2 * e), v = (at[2][1] - at[0][1]) / (2 * e);
  const Eigen::Vector2d uu = (at[1][2] + at[1][0] - 2 * at[1][1]) / (2 * e * e);
  const Eigen::Vector2d vv = (at[2][1] + at[0][1] - 2 * at[1][1]) / (2 * e * e);
  const Eigen::Vector2d uv = (at[0][0] + at[2][2] - at[0][2] - at[2][0]) / (4 * e * e);
  return PlanePatch{*pixel, field_mm, u.x(), v.x(), uu.x(), uv.x(), vv.x(), u.y(), v.y(), uu.y(), uv.y(), vv.y()};
}

}  // namespace sslv
