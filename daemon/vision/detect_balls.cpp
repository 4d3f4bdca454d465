// SPDX-License-Identifier: Apache-2.0
#include "vision/detect_balls.h"

#include "vision/color_name.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace sslv {
namespace {

/// What a ball might be taken for, or what for a ball.
constexpr std::array kLikeBalls{label::kOrange, label::kYellow, label::kPink, label::kBlue, label::kGreen};

/// Whether the ray through the pixel meets a robot's top, `inside_mm` or more within its outline.
bool lies_on_one(const std::vector<Robot>& robots, const CameraModel& camera, const Eigen::Vector2d& pixel,
                 double radius_mm, double front_mm, double inside_mm) {
  const double within_mm = radius_mm - inside_mm;
  double height_mm = std::numeric_limits<double>::quiet_NaN();
  // Where the ray meets the plane of that height, which most robots share.
  Eigen::Vector2d top = Eigen::Vector2d::Constant(height_mm);
  for (const Robot& robot : robots) {
    if (robot.height_mm != height_mm) {
      height_mm = robot.height_mm;
      top.setConstant(std::numeric_limits<double>::quiet_NaN());
      if (const auto place = camera.unproject(pixel, height_mm)) top = *place;
    }
    const double dx = top.x() - robot.x_mm, dy = top.y() - robot.y_mm;
    if (!(within_mm > 0 && dx * dx + dy * dy < within_mm * within_mm)) continue;
    const double ahead = std::cos(robot.orientation_rad) * dx + std::sin(robot.orientation_rad) * dy;
    if (ahead < front_mm - inside_mm) return true;
  }
  return false;
}

}  // namespace

void DetectBalls::process(const Params& params, const Scene& scene, const Lut& lut, const Image& image,
                          const RegionList& regions, const RobotList& robots, BallList& out) noexcept {
  out.balls.clear();
  out.capped = false;
  if (!scene.camera || image.view().empty()) return;
  const CameraModel& camera = *scene.camera;
  const double radius_mm = scene.field.ball_radius;
  const double true_area_mm2 = std::numbers::pi * radius_mm * radius_mm;
  const double max_x_mm = scene.field.field_length / 2.0 + params.max_outside_mm;
  const double max_y_mm = scene.field.field_width / 2.0 + params.max_outside_mm;
  const double robot_radius_mm = scene.field.max_robot_radius;
  // The league's robots are cut off where their front is flat.
  const double robot_front_mm = robot_radius_mm * 55 / 90;

  const BallFitter::Frame frame{image.view(),    camera,         radius_mm,     robots.robots,
                                robot_radius_mm, robot_front_mm, params.blur_px};
  int fits = 0;
  for (const Region& region : regions.of(label::kOrange)) {
    const Eigen::Vector2d pixel(region.x_px, region.y_px);
    const double ratio = region.area_px * camera.mm2_per_px(pixel, radius_mm) / true_area_mm2;
    if (!(ratio >= params.min_area_ratio && ratio <= params.max_area_ratio)) continue;
    // Cut off on two sides, too little is left to tell where its middle is.
    const bool in_corner = (region.left == 0 || region.right + 1 >= image.view().width) &&
                           (region.top == 0 || region.bottom + 1 >= image.view().height);
    if (in_corner) continue;
    const auto place = camera.unproject(pixel, radius_mm);
    if (!place || std::abs(place->x()) > max_x_mm || std::abs(place->y()) > max_y_mm) continue;
    if (lies_on_one(robots.robots, camera, pixel, robot_radius_mm, robot_front_mm, params.on_robot_mm))
      continue;
    if (++fits > params.max_fits) {
      out.capped = true;
      break;
    }
    const BallFit fit = fitter_.fit(frame, place->x(), place->y());
    if (!fit.ok) continue;
    const double confidence = confidence_of(evidence_of(fit, lut, radius_mm, ratio));
    if (confidence < params.min_confidence) continue;
    const auto fitted = camera.project({fit.x_mm, fit.y_mm, radius_mm});
    if (!fitted) continue;
    // Of several regions of one ball, the best fit counts.
    const Ball ball{fit.x_mm, fit.y_mm, fitted->x(), fitted->y(), region.area_px, confidence};
    const auto same = std::find_if(out.balls.begin(), out.balls.end(), [&](const Ball& other) {
      return std::hypot(other.x_mm - ball.x_mm, other.y_mm - ball.y_mm) < radius_mm;
    });
    if (same == out.balls.end()) {
      out.balls.push_back(ball);
    } else if (same->confidence < confidence) {
      *same = ball;
    }
  }
  std::sort(out.balls.begin(), out.balls.end(),
            [](const Ball& a, const Ball& b) { return a.confidence > b.confidence; });
  if (out.balls.size() > static_cast<std::size_t>(params.max_balls)) {
    out.balls.resize(static_cast<std::size_t>(params.max_balls));
  }
}

BallEvidence DetectBalls::evidence_of(const BallFit& fit, const Lut& lut, double radius_mm,
                                      double area_ratio) {
  BallEvidence e;
  e.r2 = fit.r2;
  e.contrast = fit.contrast;
  e.radius_off = std::abs(fit.radius_mm - radius_mm) / std::hypot(0.08 * radius_mm, fit.radius_sigma_mm);
  e.moved_share = fit.moved_mm / radius_mm;
  e.area_ratio = area_ratio / std::max(0.1, fit.visible_share);
  e.clear_share = fit.clear_share;
  e.visible_share = fit.visible_share;
  const ColorName name = name_color(fit.color, fit.color, lut, kLikeBalls);
  e.is_orange = name.color == label::kOrange && name.margin > 0;
  e.color_off = name.off;
  return e;
}

}  // namespace sslv
