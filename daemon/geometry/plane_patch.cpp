// SPDX-License-Identifier: Apache-2.0
#include "geometry/plane_patch.h"

#include <cmath>

namespace sslv {

double PlanePatch::mm_per_px() const {
  return std::sqrt(std::abs(xu * yv - xv * yu));
}

std::optional<PlanePatch> plane_patch(const CameraModel& camera, const Eigen::Vector2d& field_mm,
                                      double height_mm, double reach_mm) {
  const auto pixel = camera.project({field_mm.x(), field_mm.y(), height_mm});
  if (!pixel) return std::nullopt;
  const double area = camera.mm2_per_px(*pixel, height_mm);
  if (!(area > 0)) return std::nullopt;
  // Finite differences with half the reach as step distribute the error evenly over the patch.
  const double e = 0.5 * reach_mm / std::sqrt(area);
  const auto at = [&](double du, double dv) {
    return camera.unproject(*pixel + Eigen::Vector2d(du, dv), height_mm);
  };
  const auto right = at(e, 0), left = at(-e, 0), down = at(0, e), up = at(0, -e), both = at(e, e),
             neither = at(-e, -e);
  if (!right || !left || !down || !up || !both || !neither) return std::nullopt;
  const Eigen::Vector2d u = (*right - *left) / (2 * e), v = (*down - *up) / (2 * e);
  const Eigen::Vector2d uu = (*right + *left - 2 * field_mm) / (2 * e * e);
  const Eigen::Vector2d vv = (*down + *up - 2 * field_mm) / (2 * e * e);
  const Eigen::Vector2d uv = (*both + *neither - 2 * field_mm) / (2 * e * e) - uu - vv;
  return PlanePatch{*pixel, field_mm, u.x(), v.x(),  uu.x(), uv.x(),
                    vv.x(), u.y(),    v.y(), uu.y(), uv.y(), vv.y()};
}

}  // namespace sslv
