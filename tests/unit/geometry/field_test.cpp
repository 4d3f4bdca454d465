// SPDX-License-Identifier: Apache-2.0
#include "geometry/field.h"

#include <map>

#include <gmock/gmock.h>

namespace sslv {
namespace {

std::map<std::string, std::array<double, 4>> by_name(const std::vector<FieldLine>& lines) {
  std::map<std::string, std::array<double, 4>> out;
  for (const FieldLine& line : lines) out[line.name] = {line.x1, line.y1, line.x2, line.y2};
  EXPECT_EQ(out.size(), lines.size()) << "a name twice";
  return out;
}

TEST(Field, DivisionBLinesAreTheLeaguesDrawing) {
  const std::map<std::string, std::array<double, 4>> expected{
      {"TopTouchLine", {-4500, 3000, 4500, 3000}},
      {"BottomTouchLine", {-4500, -3000, 4500, -3000}},
      {"LeftGoalLine", {-4500, -3000, -4500, 3000}},
      {"RightGoalLine", {4500, -3000, 4500, 3000}},
      {"HalfwayLine", {0, -3000, 0, 3000}},
      {"CenterLine", {-4500, 0, 4500, 0}},
      {"LeftPenaltyStretch", {-3500, -1000, -3500, 1000}},
      {"RightPenaltyStretch", {3500, -1000, 3500, 1000}},
      {"LeftFieldLeftPenaltyStretch", {-4500, -1000, -3500, -1000}},
      {"LeftFieldRightPenaltyStretch", {-4500, 1000, -3500, 1000}},
      {"RightFieldLeftPenaltyStretch", {4500, 1000, 3500, 1000}},
      {"RightFieldRightPenaltyStretch", {4500, -1000, 3500, -1000}},
  };
  EXPECT_EQ(by_name(field_lines(FieldSize{})), expected);
}

TEST(Field, CenterLineIsOptional) {
  const auto lines = by_name(field_lines(FieldSize{}, false));
  EXPECT_EQ(lines.count("CenterLine"), 0U);
  EXPECT_EQ(lines.size(), 11U);
}

TEST(Field, OddSizesHaveTheirLinesAtHalfMillimetres) {
  FieldSize field;
  field.field_length = 9001;
  field.penalty_area_width = 2001;
  const auto lines = by_name(field_lines(field));
  EXPECT_THAT(lines.at("RightGoalLine"), testing::ElementsAre(4500.5, -3000, 4500.5, 3000));
  EXPECT_THAT(lines.at("LeftPenaltyStretch"), testing::ElementsAre(-3500.5, -1000.5, -3500.5, 1000.5));
}

TEST(Field, WhatHasNoSizeIsNotPainted) {
  FieldSize field;
  field.penalty_area_depth = 0;
  field.center_circle_radius = 0;
  EXPECT_EQ(field_lines(field).size(), 6U);
  EXPECT_TRUE(field_arcs(field).empty());
}

TEST(Field, CenterCircleIsAFullTurn) {
  const auto arcs = field_arcs(FieldSize{});
  ASSERT_EQ(arcs.size(), 1U);
  EXPECT_EQ(arcs[0].name, "CenterCircle");
  EXPECT_EQ(arcs[0].x, 0);
  EXPECT_EQ(arcs[0].y, 0);
  EXPECT_EQ(arcs[0].radius, 500);
  EXPECT_EQ(arcs[0].a1, 0);
  EXPECT_DOUBLE_EQ(arcs[0].a2, 2 * std::numbers::pi);
}

}  // namespace
}  // namespace sslv
