// SPDX-License-Identifier: Apache-2.0
#include "vision/detect_balls.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sslv {

void DetectBalls::process(const Params& params, const Scene& scene, const RegionList& regions,
                          const RobotList& robots, BallList& out) noexcept {
  out.balls.clear();
  if (!scene.camera) return;
  const CameraModel& camera = *scene.camera;
  const double radius_mm = scene.field.ball_radius;
  const double true_area_mm2 = std::numbers::pi * radius_mm * radius_mm;
  const double max_x_mm = scene.field.field_length / 2.0 + params.max_outside_mm;
  const double max_y_mm = scene.field.field_width / 2.0 + params.max_outside_mm;

  for (const Region& region : regions.of(label::kOrange)) {
    const Eigen::Vector2d pixel(region.x_px, region.y_px);
    const double ratio = region.area_px * camera.mm2_per_px(pixel, radius_mm) / true_area_mm2;
    if (ratio < params.min_area_ratio || ratio > params.max_area_ratio) continue;

    const double width = region.right - region.left + 1, height = region.bottom - region.top + 1;
    const double aspect = std::max(width, height) / std::min(width, height);
    if (aspect > params.max_aspect) continue;

    const auto place = camera.unproject(pixel, radius_mm);
    if (!place || std::abs(place->x()) > max_x_mm || std::abs(place->y()) > max_y_mm) continue;

    const bool on_robot = std::any_of(robots.robots.begin(), robots.robots.end(), [&](const Robot& robot) {
      const auto top = camera.unproject(pixel, robot.height_mm);
      return top && std::hypot(top->x() - robot.x_mm, top->y() - robot.y_mm) < params.robot_radius_mm;
    });
    if (on_robot) continue;

    // A first measure only: 1 for a blob of the ball's area in a square box, less the more it differs.
    const double confidence = std::min(ratio, 1 / ratio) / aspect;
    out.balls.push_back({place->x(), place->y(), pixel.x(), pixel.y(), region.area_px, confidence});
  }
  std::sort(out.balls.begin(), out.balls.end(),
            [](const Ball& a, const Ball& b) { return a.confidence > b.confidence; });
  if (out.balls.size() > static_cast<std::size_t>(params.max_balls)) {
    out.balls.resize(static_cast<std::size_t>(params.max_balls));
  }
}

}  // namespace sslv
