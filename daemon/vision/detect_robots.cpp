// SPDX-License-Identifier: Apache-2.0
#include "vision/detect_robots.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

namespace sslv {
namespace {

constexpr std::array kCenterLabel{label::kYellow, label::kBlue};  // by Team

/// Blobs around one centre that are tried as side dots; more would be clutter.
constexpr std::size_t kMaxNear = 24;

double disc_area_mm2(double diameter_mm) {
  return std::numbers::pi * diameter_mm * diameter_mm / 4;
}

/// The blob's place on the plane z = height if its area there suits a dot of this size.
std::optional<Eigen::Vector2d> place_of(const Region& region, const CameraModel& camera, double height_mm,
                                        double area_mm2, const DetectRobots::Params& params) {
  const Eigen::Vector2d pixel(region.x_px, region.y_px);
  const double ratio = region.area_px * camera.mm2_per_px(pixel, height_mm) / area_mm2;
  if (ratio < params.min_area_ratio || ratio > params.max_area_ratio) return std::nullopt;
  return camera.unproject(pixel, height_mm);
}

struct Pose {
  double x_mm, y_mm, angle_rad, rms_mm;
};

/// Rotation and shift that lay the pattern (centre and dots) over the blobs with the least squared error
/// (Umeyama 1991, in the plane, without scale).
Pose fit_pose(std::span<const PatternDot> model, std::span<const PatternDot> seen) {
  const auto n = static_cast<double>(model.size());
  PatternDot model_mean{0, 0}, seen_mean{0, 0};
  for (std::size_t i = 0; i < model.size(); ++i) {
    model_mean = {model_mean.x_mm + model[i].x_mm / n, model_mean.y_mm + model[i].y_mm / n};
    seen_mean = {seen_mean.x_mm + seen[i].x_mm / n, seen_mean.y_mm + seen[i].y_mm / n};
  }
  double dot = 0, cross = 0;
  for (std::size_t i = 0; i < model.size(); ++i) {
    const double mx = model[i].x_mm - model_mean.x_mm, my = model[i].y_mm - model_mean.y_mm;
    const double sx = seen[i].x_mm - seen_mean.x_mm, sy = seen[i].y_mm - seen_mean.y_mm;
    dot += mx * sx + my * sy;
    cross += mx * sy - my * sx;
  }
  const double angle = std::atan2(cross, dot), c = std::cos(angle), s = std::sin(angle);
  Pose pose{seen_mean.x_mm - (c * model_mean.x_mm - s * model_mean.y_mm),
            seen_mean.y_mm - (s * model_mean.x_mm + c * model_mean.y_mm), angle, 0};
  double squares = 0;
  for (std::size_t i = 0; i < model.size(); ++i) {
    const double ex = pose.x_mm + c * model[i].x_mm - s * model[i].y_mm - seen[i].x_mm;
    const double ey = pose.y_mm + s * model[i].x_mm + c * model[i].y_mm - seen[i].y_mm;
    squares += ex * ex + ey * ey;
  }
  pose.rms_mm = std::sqrt(squares / n);
  return pose;
}

}  // namespace

void DetectRobots::process(const Params& params, const Scene& scene, const PatternTable& patterns,
                           const RegionList& regions, RobotList& out) noexcept {
  out.robots.clear();
  candidates_.clear();
  if (!scene.camera || patterns.dots.size() > kMaxDots) return;
  double dots_height_mm = std::numeric_limits<double>::quiet_NaN();
  for (const Team team : {Team::kYellow, Team::kBlue}) {
    const double height_mm = scene.height_of(team);
    if (height_mm != dots_height_mm) collect_dots(params, scene, height_mm, patterns, regions);
    dots_height_mm = height_mm;
    for (const Region& region : regions.of(kCenterLabel[static_cast<std::size_t>(team)])) {
      const auto place =
          place_of(region, *scene.camera, height_mm, disc_area_mm2(patterns.center_diameter_mm), params);
      if (!place) continue;
      const auto index = static_cast<std::size_t>(&region - regions.regions.data());
      fit_around(params, scene, patterns, team, {place->x(), place->y(), region.label, index});
    }
  }
  choose(patterns, out);
}

void DetectRobots::collect_dots(const Params& params, const Scene& scene, double height_mm,
                                const PatternTable& patterns, const RegionList& regions) {
  dots_.clear();
  for (const Label label : patterns.side_colors) {
    for (const Region& region : regions.of(label)) {
      const auto place =
          place_of(region, *scene.camera, height_mm, disc_area_mm2(patterns.dot_diameter_mm), params);
      if (!place) continue;
      dots_.push_back(
          {place->x(), place->y(), label, static_cast<std::size_t>(&region - regions.regions.data())});
    }
  }
}

void DetectRobots::fit_around(const Params& params, const Scene& scene, const PatternTable& patterns,
                              Team team, const Dot& center) {
  double reach_mm = 0;
  for (const PatternDot& dot : patterns.dots) reach_mm = std::max(reach_mm, std::hypot(dot.x_mm, dot.y_mm));
  reach_mm += params.max_dot_error_mm;
  near_.clear();
  for (const Dot& dot : dots_) {
    if (near_.size() == kMaxNear) break;
    if (dot.region != center.region &&
        std::hypot(dot.x_mm - center.x_mm, dot.y_mm - center.y_mm) < reach_mm) {
      near_.push_back(dot);
    }
  }
  const std::size_t dot_count = patterns.dots.size();
  if (near_.size() < dot_count) return;

  // Every blob in turn is taken for every dot, which gives the heading; the others must then be where the
  // pattern has them. One dot alone would do only if it were seen without error.
  Candidate best{};
  best.rms_mm = params.max_rms_mm;
  for (const Dot& start : near_) {
    for (const PatternDot& as : patterns.dots) {
      const double distance = std::hypot(start.x_mm - center.x_mm, start.y_mm - center.y_mm);
      if (std::abs(distance - std::hypot(as.x_mm, as.y_mm)) > params.max_dot_error_mm) continue;
      const double turn =
          std::atan2(start.y_mm - center.y_mm, start.x_mm - center.x_mm) - std::atan2(as.y_mm, as.x_mm);
      try_heading(params, scene, patterns, team, center, turn, best);
    }
  }
  if (best.rms_mm < params.max_rms_mm) candidates_.push_back(best);
}

void DetectRobots::try_heading(const Params& params, const Scene& scene, const PatternTable& patterns,
                               Team team, const Dot& center, double turn_rad, Candidate& best) const {
  const std::size_t dot_count = patterns.dots.size();
  const double c = std::cos(turn_rad), s = std::sin(turn_rad);
  std::array<PatternDot, kMaxDots + 1> model{}, seen{};
  std::array<std::size_t, kMaxDots> used{};
  std::array<Label, kMaxDots> colors{};
  seen[0] = {center.x_mm, center.y_mm};
  for (std::size_t i = 0; i < dot_count; ++i) {
    const double x = center.x_mm + c * patterns.dots[i].x_mm - s * patterns.dots[i].y_mm;
    const double y = center.y_mm + s * patterns.dots[i].x_mm + c * patterns.dots[i].y_mm;
    const Dot* nearest = nullptr;
    double nearest_mm = params.max_dot_error_mm;
    for (const Dot& dot : near_) {
      const auto others = std::span(used).first(i);
      const double away_mm = std::hypot(dot.x_mm - x, dot.y_mm - y);
      if (away_mm < nearest_mm && std::find(others.begin(), others.end(), dot.region) == others.end()) {
        nearest = &dot;
        nearest_mm = away_mm;
      }
    }
    if (!nearest) return;
    used[i] = nearest->region;
    colors[i] = nearest->label;
    model[i + 1] = patterns.dots[i];
    seen[i + 1] = {nearest->x_mm, nearest->y_mm};
  }
  const auto code =
      std::find_if(patterns.codes.begin(), patterns.codes.end(), [&](const PatternTable::Code& candidate) {
        return std::equal(candidate.colors.begin(), candidate.colors.end(), colors.begin());
      });
  if (code == patterns.codes.end()) return;
  const Pose pose = fit_pose(std::span(model).first(dot_count + 1), std::span(seen).first(dot_count + 1));
  if (pose.rms_mm >= best.rms_mm) return;
  const double height_mm = scene.height_of(team);
  const auto pixel = scene.camera->project({pose.x_mm, pose.y_mm, height_mm});
  if (!pixel) return;
  // A first measure only: 1 for a perfect fit, 0 at the rms limit.
  const double confidence = 1 - pose.rms_mm / params.max_rms_mm;
  best = {
      {team, code->id, pose.x_mm, pose.y_mm, pose.angle_rad, height_mm, pixel->x(), pixel->y(), confidence},
      pose.rms_mm,
      used,
      center.region};
}

void DetectRobots::choose(const PatternTable& patterns, RobotList& out) {
  std::sort(candidates_.begin(), candidates_.end(),
            [](const Candidate& a, const Candidate& b) { return a.rms_mm < b.rms_mm; });
  taken_.clear();
  const auto is_taken = [&](std::size_t region) {
    return std::find(taken_.begin(), taken_.end(), region) != taken_.end();
  };
  for (const Candidate& candidate : candidates_) {
    const auto used = std::span(candidate.used).first(patterns.dots.size());
    if (is_taken(candidate.center_region) || std::any_of(used.begin(), used.end(), is_taken)) continue;
    const bool known = std::any_of(out.robots.begin(), out.robots.end(), [&](const Robot& other) {
      return other.team == candidate.robot.team && other.id == candidate.robot.id;
    });
    if (known) continue;
    taken_.push_back(candidate.center_region);
    taken_.insert(taken_.end(), used.begin(), used.end());
    out.robots.push_back(candidate.robot);
  }
  std::sort(out.robots.begin(), out.robots.end(),
            [](const Robot& a, const Robot& b) { return a.confidence > b.confidence; });
}

}  // namespace sslv
