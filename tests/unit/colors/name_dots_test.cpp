// SPDX-License-Identifier: Apache-2.0
#include "colors/name_dots.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace sslv::test::name_dots_test {
namespace {

/// A robot with dots of these colours, under some light.
SeenRobot robot_of(const std::vector<Label>& labels, const Color3& light = Color3::Ones()) {
  SeenRobot out;
  const Color3 black = print_color(label::kBlack).cwiseProduct(light);
  out.black = black;
  for (const Label label : labels) {
    const Color3 color = print_color(label).cwiseProduct(light);
    out.dots.push_back({color - black, color, 0, 0, 20});
  }
  return out;
}

using Labels = std::vector<Label>;
const Labels kYellowMixed{label::kYellow, label::kPink, label::kGreen, label::kGreen, label::kPink};
const Labels kBlueMixed{label::kBlue, label::kGreen, label::kPink, label::kGreen, label::kGreen};
const Labels kBluePink{label::kBlue, label::kPink, label::kPink, label::kPink, label::kPink};

TEST(NameDots, NamesGroupsUnderAnyCast) {
  for (const Color3& light :
       {Color3(1, 1, 1), Color3(1.5, 1, 0.5), Color3(0.5, 1, 1.5), Color3(0.2, 0.3, 0.2)}) {
    const std::vector<SeenRobot> robots{robot_of(kYellowMixed, light), robot_of(kBlueMixed, 0.3 * light)};
    const NamedDots named = name_dots(robots, league_patterns(), {});
    ASSERT_EQ(named.problem, "");
    EXPECT_EQ(named.labels, (std::vector<Labels>{kYellowMixed, kBlueMixed}));
    EXPECT_TRUE(named.unseen.empty());
  }
}

TEST(NameDots, ClippedChannelsMayHaveBeenBrighter) {
  std::vector<SeenRobot> robots;
  std::vector<Labels> expected;
  for (const double light : {1.2, 1.6, 2.2, 2.8}) {
    for (const Labels& labels : {kYellowMixed, kBlueMixed}) {
      SeenRobot robot = robot_of(labels, Color3::Constant(light));
      for (SeenDot& dot : robot.dots) {
        dot.color = dot.color.cwiseMin(255);
        dot.contrast = dot.color - robot.black;
      }
      robots.push_back(robot);
      expected.push_back(labels);
    }
  }
  const NamedDots named = name_dots(robots, league_patterns(), {});
  ASSERT_EQ(named.problem, "");
  EXPECT_EQ(named.labels, expected);
  for (const auto& [label, chromaticity] : named.chromaticities) {
    const Color3 printed = chromaticity_of(print_color(label) - print_color(label::kBlack));
    EXPECT_LT((chromaticity - printed).norm(), 0.08) << label::kNames[label];
  }
}

TEST(NameDots, NamesTheOnlyTeamByTheSideDots) {
  const std::vector<SeenRobot> robots{robot_of(kBlueMixed, {1.3, 1, 0.7}),
                                      robot_of(kBluePink, {1.3, 1, 0.7})};
  const NamedDots named = name_dots(robots, league_patterns(), {});
  ASSERT_EQ(named.problem, "");
  EXPECT_EQ(named.labels, (std::vector<Labels>{kBlueMixed, kBluePink}));
  EXPECT_EQ(named.unseen, Labels{label::kYellow});
  EXPECT_GT(named.gains[0], named.gains[2]);
}

TEST(NameDots, RefusesAmbiguousDots) {
  // Grey dots: as near to pink as to green.
  const Label white = label::kWhite;
  const std::vector<SeenRobot> robots{robot_of({label::kBlue, white, white, white, white})};
  EXPECT_NE(name_dots(robots, league_patterns(), {}).problem, "");
}

TEST(NameDots, FollowsTheTablesOwnColors) {
  PatternTable table = league_patterns();
  table.team_colors = {label::kWhite, label::kCyan};
  table.side_colors = {label::kBlue, label::kOrange, label::kGreen};
  const Labels a{label::kWhite, label::kBlue, label::kOrange, label::kGreen, label::kBlue},
      b{label::kCyan, label::kOrange, label::kOrange, label::kGreen, label::kBlue};
  const std::vector<SeenRobot> robots{robot_of(a, {0.8, 1, 1.1}), robot_of(b, {0.8, 1, 1.1})};
  const NamedDots named = name_dots(robots, table, {});
  ASSERT_EQ(named.problem, "");
  EXPECT_EQ(named.labels, (std::vector<Labels>{a, b}));
}

TEST(NameDots, OneOddDotMakesNoGroup) {
  std::vector<SeenRobot> robots;
  for (int i = 0; i < 4; ++i) robots.push_back(robot_of(i % 2 == 0 ? kYellowMixed : kBlueMixed));
  robots[0].dots[2].contrast = {10, 20, 200};
  const NamedDots named = name_dots(robots, league_patterns(), {});
  ASSERT_EQ(named.problem, "");
  EXPECT_EQ(named.labels[1], kBlueMixed);
  EXPECT_EQ(named.labels[3], kBlueMixed);
}

}  // namespace
}  // namespace sslv::test::name_dots_test
