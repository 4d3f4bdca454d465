// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"

#include <numbers>
#include <string>
#include <vector>

namespace sslv {

/// Sizes of the playing field in millimetres, named as in SSL_GeometryFieldSize. Defaults: Division B, 2026.
struct FieldSize {
  int field_length = 9000;
  int field_width = 6000;
  int goal_width = 1000;
  int goal_depth = 180;
  int goal_height = 160;
  int boundary_width = 300;            // behind the touch lines
  int boundary_width_goal_line = 300;  // behind the goal lines
  int penalty_area_depth = 1000;
  int penalty_area_width = 2000;
  int center_circle_radius = 500;
  int line_thickness = 10;
  int goal_center_to_penalty_mark = 6000;
  double ball_radius = 21.5;
  double max_robot_radius = 90;

  static constexpr auto fields() {
    return std::tuple{
        number("field_length", &FieldSize::field_length, 100, 100'000, "mm", "between the goal lines"),
        number("field_width", &FieldSize::field_width, 100, 100'000, "mm", "between the touch lines"),
        number("goal_width", &FieldSize::goal_width, 0, 20'000, "mm", "inner width of a goal"),
        number("goal_depth", &FieldSize::goal_depth, 0, 20'000, "mm", "depth of a goal"),
        number("goal_height", &FieldSize::goal_height, 0, 5'000, "mm", "height of a goal"),
        number("boundary_width", &FieldSize::boundary_width, 0, 20'000, "mm", "floor behind the touch lines"),
        number("boundary_width_goal_line", &FieldSize::boundary_width_goal_line, 0, 20'000, "mm",
               "floor behind the goal lines"),
        number("penalty_area_depth", &FieldSize::penalty_area_depth, 0, 50'000, "mm", "defence area along x"),
        number("penalty_area_width", &FieldSize::penalty_area_width, 0, 100'000, "mm",
               "defence area along y"),
        number("center_circle_radius", &FieldSize::center_circle_radius, 0, 50'000, "mm", "centre circle"),
        number("line_thickness", &FieldSize::line_thickness, 1, 500, "mm", "width of the painted lines"),
        number("goal_center_to_penalty_mark", &FieldSize::goal_center_to_penalty_mark, 0, 100'000, "mm",
               "from the goal's centre to the penalty mark"),
        number("ball_radius", &FieldSize::ball_radius, 5.0, 200.0, "mm", "radius of the ball"),
        number("max_robot_radius", &FieldSize::max_robot_radius, 20.0, 1000.0, "mm", "largest robot"),
    };
  }
};

/// A painted line; the coordinates are those of its centre, in field millimetres.
struct FieldLine {
  std::string name;  // the protocol's, such as "TopTouchLine"
  double x1, y1, x2, y2;
};

/// A painted circular arc from angle a1 to a2 (radians, counter-clockwise).
struct FieldArc {
  std::string name;
  double x, y, radius, a1, a2;
};

/// The league's lines for a field of this size, named as SSL_FieldShapeType. CenterLine is optional there;
/// lines of a penalty area without size are left out.
std::vector<FieldLine> field_lines(const FieldSize& field, bool with_center_line = true);
std::vector<FieldArc> field_arcs(const FieldSize& field);

}  // namespace sslv
