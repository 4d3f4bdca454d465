// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"

#include <array>
#include <cstdint>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sslv {

/// Maximum number of lines, which is also the maximum number of arcs; maximum bytes of a name. With these
/// limits, the cameras still fit into the same datagram.
inline constexpr std::size_t kMaxShapes = 200, kMaxShapeName = 60;

/// A painted line; the coordinates describe its centre, in field millimetres.
struct FieldLine {
  std::string name;  // the protocol's name, such as "TopTouchLine", or a custom name
  double x1 = 0, y1 = 0, x2 = 0, y2 = 0;
  double thickness = 0;  // in settings, 0 means the field's line_thickness

  static constexpr auto fields() {
    constexpr double kFar = 100'000;
    return std::tuple{
        text("name", &FieldLine::name, "a name of SSL_FieldShapeType for a standard line", kMaxShapeName),
        number("x1", &FieldLine::x1, -kFar, kFar, "mm", "one end, in the middle of the paint"),
        number("y1", &FieldLine::y1, -kFar, kFar, "mm", "one end"),
        number("x2", &FieldLine::x2, -kFar, kFar, "mm", "the other end"),
        number("y2", &FieldLine::y2, -kFar, kFar, "mm", "the other end"),
        number("thickness", &FieldLine::thickness, 0.0, 500.0, "mm", "width of the paint; 0: line_thickness"),
    };
  }
};

/// A painted circular arc from angle a1 to a2 (radians, counter-clockwise).
struct FieldArc {
  std::string name;
  double x = 0, y = 0, radius = 0, a1 = 0, a2 = 2 * std::numbers::pi;
  double thickness = 0;  // in settings, 0 means the field's line_thickness

  static constexpr auto fields() {
    constexpr double kFar = 100'000, kTwoTurns = 4 * std::numbers::pi;
    return std::tuple{
        text("name", &FieldArc::name, "a name of SSL_FieldShapeType for a standard arc", kMaxShapeName),
        number("x", &FieldArc::x, -kFar, kFar, "mm", "centre"),
        number("y", &FieldArc::y, -kFar, kFar, "mm", "centre"),
        number("radius", &FieldArc::radius, 0.0, kFar, "mm", "radius to the middle of the paint"),
        number("a1", &FieldArc::a1, -kTwoTurns, kTwoTurns, "rad", "start angle, counter-clockwise from +x"),
        number("a2", &FieldArc::a2, -kTwoTurns, kTwoTurns, "rad", "end angle, not below a1"),
        number("thickness", &FieldArc::thickness, 0.0, 500.0, "mm", "width of the paint; 0: line_thickness"),
    };
  }
};

/// The playing field, named as in SSL_GeometryFieldSize; sizes in millimetres. Defaults: Division B, 2026.
struct FieldSize {
  int field_length = 9000;
  int field_width = 6000;
  int goal_width = 1000;
  int goal_depth = 180;
  int goal_height = 160;
  int boundary_width = 300;            // behind the touch lines
  int boundary_width_goal_line = 300;  // behind the goal lines
  int goal_substitution_area_width = 300;
  int penalty_area_depth = 1000;
  int penalty_area_width = 2000;
  int center_circle_radius = 500;
  int line_thickness = 10;
  int goal_center_to_penalty_mark = 6000;
  double ball_radius = 21.5;
  double max_robot_radius = 90;
  std::optional<std::vector<FieldLine>> field_lines{};  // none: derived from the sizes, like the arcs
  std::optional<std::vector<FieldArc>> field_arcs{};

  static constexpr auto fields() {
    return std::tuple{
        number("field_length", &FieldSize::field_length, 100, 100'000, "mm",
               "distance between the centres of the goal lines"),
        number("field_width", &FieldSize::field_width, 100, 100'000, "mm",
               "distance between the centres of the touch lines"),
        number("goal_width", &FieldSize::goal_width, 0, 20'000, "mm", "inner width of a goal"),
        number("goal_depth", &FieldSize::goal_depth, 0, 20'000, "mm",
               "depth of a goal, from the goal line's outer edge"),
        number("goal_height", &FieldSize::goal_height, 0, 5'000, "mm", "height of a goal"),
        number("boundary_width", &FieldSize::boundary_width, 0, 20'000, "mm", "floor behind the touch lines"),
        number("boundary_width_goal_line", &FieldSize::boundary_width_goal_line, 0, 20'000, "mm",
               "floor behind the goal lines"),
        number(
            "goal_substitution_area_width", &FieldSize::goal_substitution_area_width, 0, 100'000, "mm",
            "substitution area in front of the walls behind the goals; 0: there is none, and it is not sent"),
        number("penalty_area_depth", &FieldSize::penalty_area_depth, 0, 50'000, "mm",
               "size of the defence area along x"),
        number("penalty_area_width", &FieldSize::penalty_area_width, 0, 100'000, "mm",
               "size of the defence area along y"),
        number("center_circle_radius", &FieldSize::center_circle_radius, 0, 50'000, "mm",
               "radius of the centre circle"),
        number("line_thickness", &FieldSize::line_thickness, 1, 500, "mm", "width of the painted lines"),
        number("goal_center_to_penalty_mark", &FieldSize::goal_center_to_penalty_mark, 0, 100'000, "mm",
               "distance from the goal's centre to the penalty mark"),
        number("ball_radius", &FieldSize::ball_radius, 5.0, 200.0, "mm", "radius of the ball"),
        number("max_robot_radius", &FieldSize::max_robot_radius, 20.0, 1000.0, "mm",
               "radius of the largest robot"),
        list("field_lines", &FieldSize::field_lines,
             "the painted lines; null: those that follow from the sizes", kMaxShapes),
        list("field_arcs", &FieldSize::field_arcs, "the painted arcs; null: those that follow from the sizes",
             kMaxShapes),
    };
  }
};

/// Sizes are measured to the middle of the lines, as the rules have required since February 2021 ("Field
/// Markings"), or to their outer edges, as in earlier rules and some labs. Custom lines and arcs are always
/// given by their middle.
enum class LinesMeasured : std::uint8_t { kToMiddle, kToOuterEdge };
inline constexpr std::array<Choice<LinesMeasured>, 2> kLinesMeasuredChoices{
    {{"middle", LinesMeasured::kToMiddle}, {"outer_edge", LinesMeasured::kToOuterEdge}}};

/// Converts the sizes to the rules' convention: from middle to middle of the lines.
FieldSize measured_to_middle(FieldSize field, LinesMeasured measured);

/// Whether a robot centred at (x, y) is entirely in the substitution area behind the goal line, and not in
/// the goal. The goal line is at +x if `at_positive_x`, otherwise at -x. The game controller (2026) does not
/// count a team's robots behind its own goal.
bool waits_behind_goal(const FieldSize& field, bool at_positive_x, double x_mm, double y_mm);

/// Throws SettingsError, its message starting with `path`, if names of lines and arcs are empty, too long or
/// not unique, or if an arc's a2 is below its a1.
void check_field(const FieldSize& field, const std::string& path);

/// The painted lines and arcs, each with its thickness: custom lines and arcs if the field has any, else the
/// league's lines and arcs for a field of this size, named as in SSL_FieldShapeType. CenterLine is optional
/// among the league's lines; a penalty area without size has no lines.
std::vector<FieldLine> field_lines(const FieldSize& field, bool with_center_line = true);
std::vector<FieldArc> field_arcs(const FieldSize& field);

/// A field size from the league's rules.
struct FieldPreset {
  std::string_view name;
  std::string_view help;
  FieldSize size;
};

std::span<const FieldPreset> field_presets();

/// Throws SettingsError, its message starting with `path`, for an unknown name.
const FieldSize& field_preset(const std::string& name, const std::string& path);

}  // namespace sslv
