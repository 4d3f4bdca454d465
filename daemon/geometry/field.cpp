// SPDX-License-Identifier: Apache-2.0
#include "geometry/field.h"

namespace sslv {

std::vector<FieldLine> field_lines(const FieldSize& field, bool with_center_line) {
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

std::vector<FieldArc> field_arcs(const FieldSize& field) {
  if (field.center_circle_radius <= 0) return {};
  return {{"CenterCircle", 0, 0, static_cast<double>(field.center_circle_radius), 0, 2 * std::numbers::pi}};
}

}  // namespace sslv
