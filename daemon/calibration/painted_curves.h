// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geometry/field.h"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace sslv {

/// Centre line of a painted line or arc at its true position, regardless of the part of the lines to which
/// the field's sizes were measured.
struct PaintedCurve {
  std::string name;
  double width_mm = 10;
  bool is_arc = false;
  Eigen::Vector2d from, to;  // mm; for an arc, both are its centre
  double radius_mm = 0, begin_rad = 0, end_rad = 0;

  double length_mm() const;
  /// `at_mm`: distance along the curve from its beginning.
  Eigen::Vector2d point(double at_mm) const;
  Eigen::Vector2d direction(double at_mm) const;
  double distance_mm(const Eigen::Vector2d& point_mm) const;
};

std::vector<PaintedCurve> painted_curves(const FieldSize& field,
                                         LinesMeasured measured = LinesMeasured::kToMiddle);

/// The painted lines of a field for both ways to measure its sizes: the same lines in the same order.
struct FieldCurves {
  explicit FieldCurves(const FieldSize& field);

  std::span<const PaintedCurve> measured(LinesMeasured to) const {
    return to == LinesMeasured::kToMiddle ? to_middle : to_outer_edge;
  }

  std::vector<PaintedCurve> to_middle, to_outer_edge;
};

/// Whether the field looks the same from both ends.
bool same_turned(std::span<const PaintedCurve> curves);

struct CurvePoint {
  Eigen::Vector3d place_mm;
  Eigen::Vector2d direction;
  std::size_t curve;
  double at_mm;
};

/// Points every `step_mm` along all curves, except within `clear_mm` of another curve or of an end.
std::vector<CurvePoint> points_along(std::span<const PaintedCurve> curves, double step_mm, double clear_mm);

/// A point of the field that a user can click: a corner, a crossing, a point of the circle.
struct NamedPoint {
  std::string name;  // such as "corner left top": left and right are -x and +x, top and bottom +y and -y
  Eigen::Vector2d place_mm;
};

/// All named points of a field with these curves, in the middle of the paint, where users click.
std::vector<NamedPoint> named_points(std::span<const PaintedCurve> curves);

}  // namespace sslv
