// SPDX-License-Identifier: Apache-2.0
#include "vision/patterns.h"

#include "base/error.h"

#include <gmock/gmock.h>

namespace sslv {
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

TEST(Patterns, NamesThePairThatLooksAlike) {
  // Turned by half, 4 is 9.
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
      HasSubstr("id 1 stands there twice"));
}

}  // namespace
}  // namespace sslv
