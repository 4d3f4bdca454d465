// SPDX-License-Identifier: Apache-2.0
#include "calibration/painted_curves.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>

namespace sslv {
namespace {

Eigen::Vector2d on_circle(double angle_rad) {
  return {std::cos(angle_rad), std::sin(angle_rad)};
}

}  // namespace

double PaintedCurve::length_mm() const {
  return is_arc ? radius_mm * (end_rad - begin_rad) : (to - from).norm();
}

Eigen::Vector2d PaintedCurve::point(double at_mm) const {
  if (is_arc) return from + radius_mm * on_circle(begin_rad + at_mm / radius_mm);
  return from + at_mm * direction(at_mm);
}

Eigen::Vector2d PaintedCurve::direction(double at_mm) const {
  if (!is_arc) return (to - from).normalized();
  const Eigen::Vector2d out = on_circle(begin_rad + at_mm / radius_mm);
  return {-out.y(), out.x()};
}

double PaintedCurve::distance_mm(const Eigen::Vector2d& point_mm) const {
  const Eigen::Vector2d rel = point_mm - from;
  if (is_arc) {
    double turn = std::atan2(rel.y(), rel.x()) - begin_rad;
    turn -= 2 * std::numbers::pi * std::floor(turn / (2 * std::numbers::pi));
    if (turn <= end_rad - begin_rad) return std::abs(rel.norm() - radius_mm);
    return std::min((point_mm - point(0)).norm(), (point_mm - point(length_mm())).norm());
  }
  const double at = std::clamp(rel.dot(direction(0)), 0.0, length_mm());
  return (point_mm - point(at)).norm();
}

std::vector<PaintedCurve> painted_curves(const FieldSize& field, LinesMeasured measured) {
  const FieldSize painted = measured_to_middle(field, measured);
  std::vector<PaintedCurve> out;
  for (const FieldLine& line : field_lines(painted)) {
    PaintedCurve curve;
    curve.name = line.name;
    curve.width_mm = line.thickness;
    curve.from = {line.x1, line.y1};
    curve.to = {line.x2, line.y2};
    if (curve.length_mm() >= 1) out.push_back(std::move(curve));
  }
  for (const FieldArc& arc : field_arcs(painted)) {
    PaintedCurve curve;
    curve.name = arc.name;
    curve.width_mm = arc.thickness;
    curve.is_arc = true;
    curve.from = curve.to = {arc.x, arc.y};
    curve.radius_mm = arc.radius;
    curve.begin_rad = arc.a1;
    curve.end_rad = arc.a2;
    if (curve.radius_mm > 1 && arc.a2 > arc.a1) out.push_back(std::move(curve));
  }
  return out;
}

FieldCurves::FieldCurves(const FieldSize& field)
    : to_middle(painted_curves(field)), to_outer_edge(painted_curves(field, LinesMeasured::kToOuterEdge)) {}

bool same_turned(std::span<const PaintedCurve> curves) {
  constexpr double kSameMm = 2;
  const auto is_there = [&](const Eigen::Vector2d& place) {
    return std::any_of(curves.begin(), curves.end(),
                       [&](const PaintedCurve& curve) { return curve.distance_mm(place) < kSameMm; });
  };
  return std::all_of(curves.begin(), curves.end(), [&](const PaintedCurve& curve) {
    for (const double share : {0.02, 0.27, 0.52, 0.77, 0.98}) {
      if (!is_there(-curve.point(share * curve.length_mm()))) return false;
    }
    return true;
  });
}

std::vector<CurvePoint> points_along(std::span<const PaintedCurve> curves, double step_mm, double clear_mm) {
  std::vector<CurvePoint> out;
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const PaintedCurve& curve = curves[i];
    const double length_mm = curve.length_mm();
    const bool has_ends = !curve.is_arc || curve.end_rad - curve.begin_rad < 2 * std::numbers::pi - 1e-6;
    const auto count = static_cast<int>(std::max(2.0, length_mm / step_mm));
    for (int n = 0; n < count; ++n) {
      const double at_mm = length_mm * (n + 0.5) / count;
      const Eigen::Vector2d place = curve.point(at_mm);
      bool is_clear = !has_ends || (at_mm >= clear_mm && length_mm - at_mm >= clear_mm);
      for (std::size_t k = 0; k < curves.size() && is_clear; ++k)
        is_clear = k == i || curves[k].distance_mm(place) >= clear_mm;
      if (is_clear) out.push_back({{place.x(), place.y(), 0}, curve.direction(at_mm), i, at_mm});
    }
  }
  return out;
}

std::vector<NamedPoint> named_points(std::span<const PaintedCurve> curves) {
  const auto find = [&](std::string_view name) -> const PaintedCurve* {
    const auto found = std::find_if(curves.begin(), curves.end(),
                                    [&](const PaintedCurve& curve) { return curve.name == name; });
    return found == curves.end() ? nullptr : &*found;
  };
  std::vector<NamedPoint> out;
  const auto add = [&](std::string name, double x, double y) { out.push_back({std::move(name), {x, y}}); };
  // `from` holds the y of a line along x, and the x of a line along y.
  const auto cross = [&](std::string name, const PaintedCurve* along_x, const PaintedCurve* along_y) {
    if (along_x != nullptr && along_y != nullptr) add(std::move(name), along_y->from.x(), along_x->from.y());
  };
  const PaintedCurve *top = find("TopTouchLine"), *bottom = find("BottomTouchLine"),
                     *half = find("HalfwayLine"), *middle = find("CenterLine"),
                     *circle = find("CenterCircle");
  struct Side {
    const char* name;
    const PaintedCurve *goal, *front, *area_top, *area_bottom;
  };
  const Side sides[] = {{"left", find("LeftGoalLine"), find("LeftPenaltyStretch"),
                         find("LeftFieldRightPenaltyStretch"), find("LeftFieldLeftPenaltyStretch")},
                        {"right", find("RightGoalLine"), find("RightPenaltyStretch"),
                         find("RightFieldLeftPenaltyStretch"), find("RightFieldRightPenaltyStretch")}};
  for (const Side& side : sides) {
    const std::string name = side.name;
    cross("corner " + name + " top", top, side.goal);
    cross("corner " + name + " bottom", bottom, side.goal);
    cross("defence area " + name + " top", side.area_top, side.front);
    cross("defence area " + name + " bottom", side.area_bottom, side.front);
    cross("defence area at goal line " + name + " top", side.area_top, side.goal);
    cross("defence area at goal line " + name + " bottom", side.area_bottom, side.goal);
    cross("goal line middle " + name, middle, side.goal);
    cross("defence area front middle " + name, middle, side.front);
  }
  cross("halfway line top", top, half);
  cross("halfway line bottom", bottom, half);
  cross("centre", middle, half);
  if (circle != nullptr) {
    const Eigen::Vector2d c = circle->from;
    const double r = circle->radius_mm;
    if (middle == nullptr && half != nullptr) add("centre", c.x(), c.y());
    add("circle top", c.x(), c.y() + r);
    add("circle bottom", c.x(), c.y() - r);
    add("circle left", c.x() - r, c.y());
    add("circle right", c.x() + r, c.y());
  }
  return out;
}

}  // namespace sslv
