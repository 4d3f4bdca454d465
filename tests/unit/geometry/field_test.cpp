// SPDX-License-Identifier: Apache-2.0
#include "geometry/field.h"

#include "base/error.h"
#include "base/params_json.h"

#include <map>

#include <gmock/gmock.h>

namespace sslv::field_test {
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

TEST(Field, LinesOfSizeZeroAreNotPainted) {
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

TEST(Field, PresetsHaveTheSizesOf2026) {
  const FieldSize& a = field_preset("division-a", "");
  EXPECT_EQ(a.field_length, 12000);
  EXPECT_EQ(a.field_width, 9000);
  EXPECT_EQ(a.boundary_width, 300);
  EXPECT_EQ(a.boundary_width_goal_line, 600);
  EXPECT_EQ(a.goal_width, 1800);
  EXPECT_EQ(a.goal_depth, 180);
  EXPECT_EQ(a.goal_height, 160);
  EXPECT_EQ(a.penalty_area_width, 3600);
  EXPECT_EQ(a.penalty_area_depth, 1800);
  EXPECT_EQ(a.goal_center_to_penalty_mark, 8000);
  EXPECT_EQ(a.goal_substitution_area_width, 300);
  EXPECT_EQ(params_to_json(field_preset("division-b", "")), params_to_json(FieldSize{}));
  EXPECT_EQ(FieldSize{}.goal_substitution_area_width, 300);
}

TEST(Field, EveryPresetIsAllowedAsSettings) {
  for (const FieldPreset& preset : field_presets()) {
    const Json settings = params_to_json(preset.size);
    EXPECT_EQ(params_to_json(params_from_json<FieldSize>(settings, "/field")), settings) << preset.name;
  }
}

TEST(Field, AnUnknownPresetIsRefusedWithThoseThereAre) {
  try {
    field_preset("division-c", "/field/preset");
    ADD_FAILURE() << "it was accepted";
  } catch (const SettingsError& error) {
    EXPECT_STREQ(error.what(),
                 R"(/field/preset: "division-c" is not allowed; expected one of "division-a" "division-b")");
  }
}

FieldSize from_settings(const char* settings) {
  return params_from_json<FieldSize>(Json::parse(settings), "/field");
}

TEST(Field, GivenLinesAndArcsReplaceTheLeagues) {
  const FieldSize field = from_settings(R"({
    "line_thickness": 12,
    "field_lines": [{"name": "TopTouchLine", "x1": -4480, "y1": 2990, "x2": 4505, "y2": 3004},
                    {"name": "Tape", "x2": 100, "thickness": 25.5}],
    "field_arcs": [{"name": "CenterCircle", "x": 5, "y": -5, "radius": 490, "a1": -1, "a2": 1}]})");
  check_field(field, "/field");
  const auto lines = field_lines(field);
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(params_to_json(lines[0]), Json::parse(R"({"name": "TopTouchLine", "x1": -4480.0, "y1": 2990.0,
                                                      "x2": 4505.0, "y2": 3004.0, "thickness": 12.0})"));
  EXPECT_EQ(lines[1].thickness, 25.5);
  const auto arcs = field_arcs(field);
  ASSERT_EQ(arcs.size(), 1U);
  EXPECT_EQ(arcs[0].a1, -1);
  EXPECT_EQ(arcs[0].thickness, 12);
}

TEST(Field, RobotsWaitInFrontOfTheWallBehindTheGoal) {
  const FieldSize& a =
      field_preset("division-a", "");  // goal line at 6000, area from 6300 to the wall at 6600
  EXPECT_TRUE(waits_behind_goal(a, true, 6390, -4700));
  EXPECT_FALSE(waits_behind_goal(a, true, 6389, 0)) << "not all of it";
  EXPECT_FALSE(waits_behind_goal(a, true, -6400, 0)) << "behind the other goal";
  EXPECT_TRUE(waits_behind_goal(a, false, -6400, 0));
  EXPECT_FALSE(waits_behind_goal(a, true, 6700, 0));
  EXPECT_FALSE(waits_behind_goal(a, true, 6400, 4900));
  FieldSize b = field_preset("division-b", "");  // goal line at 4500, where the area begins
  EXPECT_TRUE(waits_behind_goal(b, true, 4590, 600));
  EXPECT_FALSE(waits_behind_goal(b, true, 4589, 600));
  for (const double x_mm : {4590.0, 4680.0}) {
    EXPECT_FALSE(waits_behind_goal(b, true, x_mm, -400)) << "a keeper in its goal";
    EXPECT_FALSE(waits_behind_goal(b, false, -x_mm, 400));
  }
  EXPECT_TRUE(waits_behind_goal(b, true, 4690, 0)) << "behind the goal";
  b.goal_substitution_area_width = 600;
  EXPECT_FALSE(waits_behind_goal(b, true, 4589, 600)) << "it may only be said to begin on the field";
  b.goal_substitution_area_width = 0;
  EXPECT_FALSE(waits_behind_goal(b, true, 4600, 600)) << "there is none";
}

TEST(Field, AnEmptyListPaintsNothingAndNullPaintsTheUsualLines) {
  const FieldSize none = from_settings(R"({"field_lines": [], "field_arcs": []})");
  EXPECT_TRUE(field_lines(none).empty());
  EXPECT_TRUE(field_arcs(none).empty());
  const FieldSize usual = from_settings(R"({"field_lines": null, "field_arcs": null})");
  EXPECT_EQ(field_lines(usual).size(), 12U);
  EXPECT_EQ(field_arcs(usual).size(), 1U);
}

TEST(Field, LinesThatCannotBeToldApartAreRefused) {
  const auto refusal = [](const char* settings) -> std::string {
    try {
      check_field(from_settings(settings), "/field");
    } catch (const SettingsError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(
      refusal(R"({"field_lines": [{"name": "A"}, {"name": "B"}, {"name": "A"}]})"),
      R"(/field/field_lines/2/name: "A" is not allowed; expected a name other than that of /field/field_lines/0)");
  EXPECT_EQ(
      refusal(R"({"field_lines": [{"name": "A"}], "field_arcs": [{"name": "A"}]})"),
      R"(/field/field_arcs/0/name: "A" is not allowed; expected a name other than that of /field/field_lines/0)");
  EXPECT_EQ(refusal(R"({"field_lines": [{"x1": 5}]})"),
            R"(/field/field_lines/0/name: "" is not allowed; expected a name of at most 60 bytes)");
  EXPECT_EQ(refusal(R"({"field_arcs": [{"name": "A", "a1": 2, "a2": 1}]})"),
            "/field/field_arcs/0/a2: 1.0 is not allowed; expected an angle not below a1, 2.0");
  EXPECT_EQ(refusal(R"({"field_lines": 3})"),
            "/field/field_lines: 3 is not allowed; expected a list or null");
  Json many = Json::array();
  for (int i = 0; i < 201; ++i) many.push_back({{"name", std::to_string(i)}});
  EXPECT_EQ(refusal(Json{{"field_lines", many}}.dump().c_str()),
            "/field/field_lines: 201 entries are not allowed; expected at most 200");
}

}  // namespace
}  // namespace sslv::field_test
