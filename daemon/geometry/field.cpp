// SPDX-License-Identifier: Apache-2.0
#include "geometry/field.h"

#include "base/params_json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace sslv {
namespace {

std::vector<FieldLine> league_lines(const FieldSize& field, bool with_center_line) {
  const double a = field.field_length / 2.0, b = field.field_width / 2.0;
  const double px = a - field.penalty_area_depth, py = field.penalty_area_width / 2.0;
  std::vector<FieldLine> lines{
      {"TopTouchLine", -a, b, a, b},  {"BottomTouchLine", -a, -b, a, -b}, {"LeftGoalLine", -a, -b, -a, b},
      {"RightGoalLine", a, -b, a, b}, {"HalfwayLine", 0, -b, 0, b},
  };
  if (with_center_line) lines.push_back({"CenterLine", -a, 0, a, 0});
  if (field.penalty_area_depth > 0 && field.penalty_area_width > 0) {
    lines.insert(lines.end(), {
                                  {"LeftPenaltyStretch", -px, -py, -px, py},
                                  {"RightPenaltyStretch", px, -py, px, py},
                                  {"LeftFieldLeftPenaltyStretch", -a, -py, -px, -py},
                                  {"LeftFieldRightPenaltyStretch", -a, py, -px, py},
                                  {"RightFieldLeftPenaltyStretch", a, py, px, py},
                                  {"RightFieldRightPenaltyStretch", a, -py, px, -py},
                              });
  }
  return lines;
}

std::vector<FieldArc> league_arcs(const FieldSize& field) {
  if (field.center_circle_radius <= 0) return {};
  return {{"CenterCircle", 0, 0, static_cast<double>(field.center_circle_radius)}};
}

template <class Shape>
std::vector<Shape> with_thickness(std::vector<Shape> shapes, const FieldSize& field) {
  for (Shape& shape : shapes) {
    if (shape.thickness == 0) shape.thickness = field.line_thickness;
  }
  return shapes;
}

/// `path_of_name`: the names found so far, with their paths.
template <class Shape>
void check_names(const std::vector<Shape>& shapes, const std::string& path,
                 std::map<std::string, std::string>& path_of_name) {
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const std::string& name = shapes[i].name;
    const std::string here = path + "/" + std::to_string(i);
    if (name.empty() || name.size() > kMaxShapeName) {
      refuse(here + "/name", name, "a name of at most " + std::to_string(kMaxShapeName) + " bytes");
    }
    const auto [first, is_new] = path_of_name.emplace(name, here);
    if (!is_new) refuse(here + "/name", name, "a name other than that of " + first->second);
  }
}

/// Subtracts the width of the paint. A size that would shrink below 2 mm stays unchanged, so that no line
/// disappears.
double less_paint(double size_mm, double paint_mm) {
  constexpr double kLeastMm = 2;
  return size_mm - paint_mm >= kLeastMm ? size_mm - paint_mm : size_mm;
}

}  // namespace

FieldSize measured_to_middle(FieldSize field, LinesMeasured measured) {
  if (measured == LinesMeasured::kToMiddle) return field;
  const int paint_mm = field.line_thickness;
  // The arcs become custom arcs, because center_circle_radius holds whole millimetres only.
  std::vector<FieldArc> arcs = field_arcs(field);
  if (!field.field_arcs) {
    for (FieldArc& arc : arcs) arc.radius = less_paint(arc.radius, paint_mm / 2.0);
  }
  field.field_arcs = std::move(arcs);
  for (const auto size : {&FieldSize::field_length, &FieldSize::field_width, &FieldSize::penalty_area_depth,
                          &FieldSize::penalty_area_width})
    field.*size = static_cast<int>(less_paint(field.*size, paint_mm));
  return field;
}

bool waits_behind_goal(const FieldSize& field, bool at_positive_x, double x_mm, double y_mm) {
  if (field.goal_substitution_area_width <= 0) return false;
  const double goal_line_mm = field.field_length / 2.0;
  const double wall_mm = goal_line_mm + field.boundary_width_goal_line;
  // A larger width does not extend into the playing area.
  const double begin_mm = std::max(goal_line_mm, wall_mm - field.goal_substitution_area_width);
  const double along_mm = at_positive_x ? x_mm : -x_mm;
  // In Division B, the area begins at the goal line, so exclude the goal, in which a goalkeeper may stand.
  if (std::abs(y_mm) < field.goal_width / 2.0 &&
      along_mm <= goal_line_mm + field.line_thickness / 2.0 + field.goal_depth)
    return false;
  return along_mm >= begin_mm + field.max_robot_radius && along_mm <= wall_mm &&
         std::abs(y_mm) <= field.field_width / 2.0 + field.boundary_width;
}

void check_field(const FieldSize& field, const std::string& path) {
  std::map<std::string, std::string> path_of_name;
  if (field.field_lines) check_names(*field.field_lines, path + "/field_lines", path_of_name);
  if (!field.field_arcs) return;
  check_names(*field.field_arcs, path + "/field_arcs", path_of_name);
  for (std::size_t i = 0; i < field.field_arcs->size(); ++i) {
    const FieldArc& arc = (*field.field_arcs)[i];
    if (arc.a2 < arc.a1) {
      refuse(path + "/field_arcs/" + std::to_string(i) + "/a2", arc.a2,
             "an angle not below a1, " + json_text(Json(arc.a1)));
    }
  }
}

std::vector<FieldLine> field_lines(const FieldSize& field, bool with_center_line) {
  return with_thickness(field.field_lines.value_or(league_lines(field, with_center_line)), field);
}

std::vector<FieldArc> field_arcs(const FieldSize& field) {
  return with_thickness(field.field_arcs.value_or(league_arcs(field)), field);
}

std::span<const FieldPreset> field_presets() {
  static const std::array kPresets{
      FieldPreset{"division-a",
                  "Division A, 2026",
                  {.field_length = 12000,
                   .field_width = 9000,
                   .goal_width = 1800,
                   .boundary_width_goal_line = 600,
                   .goal_substitution_area_width = 300,
                   .penalty_area_depth = 1800,
                   .penalty_area_width = 3600,
                   .goal_center_to_penalty_mark = 8000}},
      FieldPreset{"division-b", "Division B, 2026", {}},
  };
  return kPresets;
}

const FieldSize& field_preset(const std::string& name, const std::string& path) {
  std::string allowed = "one of";
  for (const FieldPreset& preset : field_presets()) {
    if (preset.name == name) return preset.size;
    allowed += " \"" + std::string(preset.name) + "\"";
  }
  refuse(path, name, allowed);
}

}  // namespace sslv
