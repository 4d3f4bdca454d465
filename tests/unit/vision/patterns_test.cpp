// SPDX-License-Identifier: Apache-2.0
#include "vision/patterns.h"

#include "base/error.h"
#include "vision/patterns_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include <gmock/gmock.h>

namespace sslv::patterns_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string error_of(const std::string& json) {
  try {
    parse_patterns(json, "lab.json");
  } catch (const SettingsError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Patterns, TheLeaguesSixteenAreBuiltIn) {
  const PatternTable& table = league_patterns();
  EXPECT_EQ(table.codes.size(), 16u);
  EXPECT_EQ(table.dots.size(), 4u);
  EXPECT_EQ(table.side_colors.size(), 2u);
  for (std::size_t i = 0; i < 16; ++i) EXPECT_EQ(table.codes[i].id, static_cast<int>(i));
  using namespace label;
  EXPECT_EQ(table.codes[6].colors, (std::vector<Label>{kGreen, kPink, kGreen, kGreen}));
}

TEST(Patterns, OtherArrangementsAreData) {
  const PatternTable table =
      parse_patterns(R"({"name": "lab", "center_diameter_mm": 30, "dot_diameter_mm": 20,
      "dots": [[40, 0], [-40, 0]], "codes": [{"id": 1, "colors": ["pink", "cyan"]}]})",
                     "lab.json");
  EXPECT_EQ(table.dots.size(), 2u);
  EXPECT_EQ(table.side_colors, (std::vector<Label>{label::kPink, label::kCyan}));
}

TEST(Patterns, AreWrittenAsTheyAreRead) {
  const LabelSet labels({{12, "purple"}}, "");
  const std::string json =
      R"({"name": "lab", "center_diameter_mm": 30.25, "center": [-5, 2], "dot_diameter_mm": 20, "top_radius_mm": 80.5,
      "dots": [[40, 0.1], [-40, 0, 21]], "team_colors": {"yellow": "purple", "blue": "blue"},
      "codes": [{"id": 1, "colors": ["pink", "cyan"]}, {"id": 7, "colors": ["pink", "purple"]}]})";
  const PatternTable table = parse_patterns(json, "lab.json", labels);
  const PatternTable again = parse_patterns(patterns_text(table, labels), "again", labels);
  EXPECT_EQ(again.name, table.name);
  EXPECT_EQ(again.center_diameter_mm, table.center_diameter_mm);
  EXPECT_EQ(again.center_x_mm, -5);
  EXPECT_EQ(again.center_y_mm, 2);
  EXPECT_EQ(again.team_colors, table.team_colors);
  EXPECT_EQ(again.top_radius_mm, table.top_radius_mm);
  EXPECT_EQ(again.top_front_mm, table.top_front_mm);
  EXPECT_EQ(again.side_colors, table.side_colors);
  ASSERT_EQ(again.dots.size(), table.dots.size());
  for (std::size_t i = 0; i < table.dots.size(); ++i) {
    EXPECT_EQ(again.dots[i].x_mm, table.dots[i].x_mm);
    EXPECT_EQ(again.dots[i].y_mm, table.dots[i].y_mm);
    EXPECT_EQ(again.dots[i].diameter_mm, table.dots[i].diameter_mm);
  }
  ASSERT_EQ(again.codes.size(), table.codes.size());
  EXPECT_EQ(again.codes[1].colors, table.codes[1].colors);
  EXPECT_EQ(patterns_text(again, labels), patterns_text(table, labels));
  EXPECT_EQ(patterns_text(parse_patterns(patterns_text(league_patterns()), "")),
            patterns_text(league_patterns()));
}

TEST(Patterns, TheCentreDotMayBeOffTheCentre) {
  const auto with_center = [](const std::string& center) {
    return R"({"name": "lab", "center_diameter_mm": 30, "center": )" + center +
           R"(, "dot_diameter_mm": 20, "dots": [[40, 0], [0, 40]],
               "codes": [{"id": 1, "colors": ["pink", "pink"]}, {"id": 2, "colors": ["green", "green"]}]})";
  };
  const PatternTable table = parse_patterns(with_center("[-20, -10]"), "lab.json");
  EXPECT_DOUBLE_EQ(table.reach_mm, 50);
  EXPECT_DOUBLE_EQ(table.arm_mm, std::hypot(60, 10) + 10);
  const PatternPose robot = table.with_center_at(100, 200, std::numbers::pi / 2);
  EXPECT_NEAR(robot.x_mm, 90, 1e-9);
  EXPECT_NEAR(robot.y_mm, 220, 1e-9);
  EXPECT_NEAR(table.center_of(robot)[0], 100, 1e-9);
  EXPECT_NEAR(table.center_of(robot)[1], 200, 1e-9);
  EXPECT_THAT(error_of(with_center("[-80, 0]")), HasSubstr("lab.json/center: extends beyond the rim"));
  EXPECT_THAT(error_of(with_center("[20, 0]")), HasSubstr("lab.json/dots/0: overlaps the centre dot"));
  EXPECT_THAT(error_of(with_center("7")),
              HasSubstr("lab.json/center: 7 is not allowed; expected [x, y] in mm"));
}

TEST(Patterns, MayHaveOwnLabels) {
  const std::string json = R"({"name": "lab", "center_diameter_mm": 30, "dot_diameter_mm": 20,
      "dots": [[40, 0], [-40, 0]], "codes": [{"id": 1, "colors": ["pink", "purple"]}]})";
  const PatternTable table = parse_patterns(json, "lab.json", LabelSet({{12, "purple"}}, ""));
  EXPECT_EQ(table.side_colors, (std::vector<Label>{label::kPink, 12}));
  EXPECT_THAT(error_of(json), HasSubstr("\"purple\" is not allowed"));
}

TEST(Patterns, NamesThePairThatLooksAlike) {
  // Turned by 180 degrees, 4 looks like 9.
  EXPECT_THAT(error_of(R"({"name": "lab", "center_diameter_mm": 30, "dot_diameter_mm": 20,
      "dots": [[40, 0], [-40, 0]], "codes": [{"id": 4, "colors": ["pink", "cyan"]}, {"id": 9, "colors": ["cyan", "pink"]}]})"),
              HasSubstr("ids 4 and 9 look alike"));
}

TEST(Patterns, NamesWhatIsWrong) {
  EXPECT_THAT(error_of("{"), HasSubstr("lab.json"));
  EXPECT_THAT(error_of(R"({"name": "x"})"), HasSubstr("lab.json/center_diameter_mm: is missing"));
  EXPECT_THAT(error_of(R"({"name": "lab", "center_diameter_mm": 30, "dot_diameter_mm": 20,
      "dots": [[40, 0], [-40, 0]], "codes": [{"id": 1, "colors": ["pink"]}]})"),
              AllOf(HasSubstr("lab.json/codes/0/colors"), HasSubstr("2 colours")));
  EXPECT_THAT(
      error_of(
          R"({"name": "lab", "center_diameter_mm": 30, "dot_diameter_mm": 20, "dots": [[40, 0], [-40, 0]],
      "codes": [{"id": 1, "colors": ["pink", "cyan"]}, {"id": 1, "colors": ["pink", "pink"]}]})"),
      HasSubstr("id 1 is in the list twice"));
}

// ---- sizes

/// A table of two dots with more keys; `dots` and `keys` are JSON.
std::string table(const std::string& dots, const std::string& keys = "") {
  return R"({"name": "lab", "center_diameter_mm": 50, "dot_diameter_mm": 40, "dots": )" + dots + keys +
         R"(, "codes": [{"id": 1, "colors": ["pink", "cyan"]}]})";
}

TEST(Patterns, TheLeaguesSizes) {
  const PatternTable& league = league_patterns();
  EXPECT_EQ(league.top_radius_mm, 90);
  EXPECT_EQ(league.top_front_mm, 55);
  EXPECT_EQ(league.team_colors, (std::array{label::kYellow, label::kBlue}));
  EXPECT_NEAR(league.reach_mm, 85, 0.01);
  EXPECT_NEAR(league.gap_mm, 20, 0.01);  // from the centre dot to any other
  ASSERT_EQ(league.rings.size(), 1u);
  EXPECT_NEAR(league.rings[0].radius_mm, 65, 0.01);
  EXPECT_EQ(league.rings[0].dot_angles_rad.size(), 4u);
  EXPECT_TRUE(std::is_sorted(league.rings[0].dot_angles_rad.begin(), league.rings[0].dot_angles_rad.end()));
  // Behind and at both sides; the gap ahead would be beyond the flat front.
  EXPECT_EQ(league.rings[0].gap_angles_rad.size(), 3u);
}

TEST(Patterns, DotsMayDifferInSize) {
  const PatternTable lab = parse_patterns(table("[[60, 0, 30], [-60, 0]]"), "lab.json");
  EXPECT_EQ(lab.dots[0].diameter_mm, 30);
  EXPECT_EQ(lab.dots[1].diameter_mm, 40);
  EXPECT_NEAR(lab.reach_mm, 80, 1e-9);
  EXPECT_NEAR(lab.gap_mm, 60 - 25 - 20, 1e-9);
}

TEST(Patterns, TheTopIsRoundUnlessItSaysOtherwise) {
  const PatternTable round =
      parse_patterns(table("[[60, 0], [-60, 0]]", R"(, "top_radius_mm": 85)"), "lab.json");
  EXPECT_EQ(round.top_radius_mm, 85);
  EXPECT_EQ(round.top_front_mm, 85);
  const PatternTable flat = parse_patterns(
      table("[[0, 60], [0, -60]]", R"(, "top_radius_mm": 85, "top_front_mm": 50)"), "lab.json");
  EXPECT_EQ(flat.top_front_mm, 50);
}

TEST(Patterns, TeamsMayHaveOtherColours) {
  const PatternTable lab = parse_patterns(
      table("[[60, 0], [-60, 0]]", R"(, "team_colors": {"yellow": "orange", "blue": "white"})"), "lab.json");
  EXPECT_EQ(lab.team_colors, (std::array{label::kOrange, label::kWhite}));
}

TEST(Patterns, RingsHoldTheDotsThatAreAboutAsFarOut) {
  const PatternTable lab = parse_patterns(
      R"({"name": "lab", "center_diameter_mm": 30, "dot_diameter_mm": 20, "dots": [[40, 0], [-42, 0], [0, 70]],
          "codes": [{"id": 1, "colors": ["pink", "cyan", "pink"]}]})",
      "lab.json");
  ASSERT_EQ(lab.rings.size(), 2u);
  EXPECT_EQ(lab.rings[0].dot_angles_rad.size(), 2u);
  EXPECT_EQ(lab.rings[0].gap_angles_rad.size(), 2u);
  EXPECT_NEAR(lab.rings[1].radius_mm, 70, 1e-9);
  EXPECT_GT(lab.rings[1].spread_mm, 0);
  EXPECT_LT(lab.rings[1].spread_mm, 10);
}

TEST(Patterns, NamesDotsThatOverlap) {
  EXPECT_THAT(error_of(table("[[60, 0], [62, 30]]")),
              AllOf(HasSubstr("lab.json/dots/1"), HasSubstr("overlaps dot 0")));
  EXPECT_THAT(error_of(table("[[60, 0], [-40, 0]]")),
              AllOf(HasSubstr("lab.json/dots/1"), HasSubstr("overlaps the centre dot")));
  EXPECT_THAT(error_of(table("[[50, 0, 60], [-60, 0]]")),
              AllOf(HasSubstr("lab.json/dots/0"), HasSubstr("overlaps the centre dot")));
  EXPECT_EQ(error_of(table("[[45, 0], [-45, 0]]")), "no error") << "dots that touch do not overlap";
}

TEST(Patterns, NamesDotsThatStandOverTheRim) {
  EXPECT_THAT(error_of(table("[[60, 0], [-75, 0]]")), AllOf(HasSubstr("lab.json/dots/1"), HasSubstr("rim")));
  EXPECT_THAT(error_of(table("[[0, 60], [50, 0]]", R"(, "top_front_mm": 55)")),
              AllOf(HasSubstr("lab.json/dots/1"), HasSubstr("rim"), HasSubstr("55")));
  EXPECT_THAT(error_of(table("[[60, 0], [-60, 0]]", R"(, "top_radius_mm": 70)")),
              AllOf(HasSubstr("lab.json/dots/0"), HasSubstr("70")));
}

TEST(Patterns, NamesWhatIsWrongWithSizesAndColours) {
  EXPECT_THAT(error_of(table("[[60, 0, 0], [-60, 0]]")), HasSubstr("lab.json/dots/0/2"));
  EXPECT_THAT(error_of(table("[[60, 0, 30, 1], [-60, 0]]")), HasSubstr("lab.json/dots/0"));
  EXPECT_THAT(error_of(table("[[60], [-60, 0]]")), HasSubstr("lab.json/dots/0"));
  EXPECT_THAT(error_of(table("[[60, 0], [-60, 0]]", R"(, "top_radius_mm": 0)")),
              HasSubstr("lab.json/top_radius_mm"));
  EXPECT_THAT(error_of(table("[[60, 0], [-60, 0]]", R"(, "top_front_mm": "far")")),
              HasSubstr("lab.json/top_front_mm"));
  EXPECT_THAT(error_of(table("[[60, 0], [-60, 0]]", R"(, "team_colors": {"yellow": "yellow"})")),
              HasSubstr("lab.json/team_colors"));
  EXPECT_THAT(
      error_of(table("[[60, 0], [-60, 0]]", R"(, "team_colors": {"yellow": "mauve", "blue": "blue"})")),
      HasSubstr("lab.json/team_colors/yellow"));
  EXPECT_THAT(
      error_of(table("[[60, 0], [-60, 0]]", R"(, "team_colors": {"yellow": "blue", "blue": "blue"})")),
      AllOf(HasSubstr("lab.json/team_colors"), HasSubstr("same colour")));
  EXPECT_THAT(
      error_of(table("[[60, 0], [-60, 0]]", R"(, "top_width_mm": 3)")),
      AllOf(HasSubstr("lab.json/top_width_mm"), HasSubstr("top_radius_mm"), HasSubstr("team_colors")));
}

}  // namespace
}  // namespace sslv::patterns_test
