// SPDX-License-Identifier: Apache-2.0
#include "capture/simulator/simulator_world.h"

#include "base/error.h"

#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

namespace sslv::simulator_world_test {
namespace {

constexpr std::array<double, 2> kHeightsMm{140, 150};

double distance_mm(double x1, double y1, double x2, double y2) {
  return std::hypot(x1 - x2, y1 - y2);
}

struct Case {
  int robots_per_team, balls;
  FieldSize field;
};

TEST(SimulatedWorld, NothingEverTouchesOrLeavesTheField) {
  FieldSize small;
  small.field_length = 4000;
  small.field_width = 3000;
  FieldSize upright;
  upright.field_length = 3000;
  upright.field_width = 6000;
  FieldSize large;
  large.field_length = 12000;
  large.field_width = 9000;
  const Case cases[] = {{1, 1, {}},     {6, 1, {}},   {6, 10, small},
                        {11, 2, large}, {16, 10, {}}, {8, 3, upright}};
  double nearest_robots = 1e9, nearest_ball = 1e9;
  for (const Case& c : cases) {
    for (int seed = 0; seed < 10; ++seed) {
      SimulatorOptions options;
      options.robots_yellow = options.robots_blue = c.robots_per_team;
      options.balls = c.balls;
      options.seed = seed;
      const SimulatedWorld world(options, c.field, kHeightsMm);
      for (int i = 0; i < 600; ++i) {
        const SimulatedScene scene = world.at(1.79e9 + 0.37 * i);
        ASSERT_EQ(scene.robots.size(), 2U * static_cast<std::size_t>(c.robots_per_team));
        ASSERT_EQ(scene.balls.size(), static_cast<std::size_t>(c.balls));
        for (std::size_t a = 0; a < scene.robots.size(); ++a) {
          const SimulatedRobot& robot = scene.robots[a];
          ASSERT_LE(std::abs(robot.x_mm), c.field.field_length / 2.0 - 90);
          ASSERT_LE(std::abs(robot.y_mm), c.field.field_width / 2.0 - 90);
          for (std::size_t b = 0; b < a; ++b) {
            nearest_robots =
                std::min(nearest_robots,
                         distance_mm(robot.x_mm, robot.y_mm, scene.robots[b].x_mm, scene.robots[b].y_mm));
          }
          for (const SimulatedBall& ball : scene.balls) {
            nearest_ball = std::min(nearest_ball, distance_mm(robot.x_mm, robot.y_mm, ball.x_mm, ball.y_mm));
          }
        }
        for (std::size_t a = 0; a < scene.balls.size(); ++a) {
          for (std::size_t b = 0; b < a; ++b) {
            ASSERT_GE(distance_mm(scene.balls[a].x_mm, scene.balls[a].y_mm, scene.balls[b].x_mm,
                                  scene.balls[b].y_mm),
                      43);
          }
        }
      }
    }
  }
  EXPECT_GE(nearest_robots, 180 + kSimulatorClearanceMm);
  EXPECT_GE(nearest_ball, 90 + 21.5 + kSimulatorClearanceMm);
  // The scenes contain the hard cases of a match.
  EXPECT_LT(nearest_robots, 210);
  EXPECT_LT(nearest_ball, 150);
}

TEST(SimulatedWorld, MovesSmoothlyAndTurns) {
  const SimulatedWorld world(SimulatorOptions{}, FieldSize{}, kHeightsMm);
  constexpr double kStepS = 0.02;
  double max_moved_mm = 0, max_turned_rad = 0, travelled_mm = 0;
  double min_heading = 10, max_heading = -10;
  for (int i = 0; i < 5000; ++i) {
    const SimulatedScene a = world.at(100 + i * kStepS), b = world.at(100 + (i + 1) * kStepS);
    for (std::size_t r = 0; r < a.robots.size(); ++r) {
      const auto &from = a.robots[r], &to = b.robots[r];
      max_moved_mm = std::max(max_moved_mm, distance_mm(from.x_mm, from.y_mm, to.x_mm, to.y_mm));
      const double turned = std::remainder(to.orientation_rad - from.orientation_rad, 2 * std::numbers::pi);
      max_turned_rad = std::max(max_turned_rad, std::abs(turned));
    }
    travelled_mm += distance_mm(a.robots[0].x_mm, a.robots[0].y_mm, b.robots[0].x_mm, b.robots[0].y_mm);
    min_heading = std::min(min_heading, a.robots[0].orientation_rad);
    max_heading = std::max(max_heading, a.robots[0].orientation_rad);
  }
  EXPECT_LT(max_moved_mm, 3000 * kStepS);
  EXPECT_LT(max_turned_rad, 8 * kStepS);
  EXPECT_GT(travelled_mm, 100 * 200);
  EXPECT_GT(min_heading, -std::numbers::pi);
  EXPECT_LE(max_heading, std::numbers::pi);
  EXPECT_LT(min_heading, -2.5);
  EXPECT_GT(max_heading, 2.5);
}

TEST(SimulatedWorld, IsAFunctionOfOptionsAndTime) {
  SimulatorOptions options;
  const SimulatedWorld one(options, FieldSize{}, kHeightsMm), same(options, FieldSize{}, kHeightsMm);
  options.seed = 2;
  const SimulatedWorld other(options, FieldSize{}, kHeightsMm);
  const SimulatedScene a = one.at(1.79e9), b = same.at(1.79e9), c = other.at(1.79e9);
  for (std::size_t i = 0; i < a.robots.size(); ++i) {
    EXPECT_EQ(a.robots[i].x_mm, b.robots[i].x_mm);
    EXPECT_EQ(a.robots[i].orientation_rad, b.robots[i].orientation_rad);
    EXPECT_EQ(a.robots[i].height_mm, a.robots[i].team == Team::kYellow ? 140 : 150);
  }
  EXPECT_NE(a.robots[0].x_mm, c.robots[0].x_mm);
}

TEST(SimulatedWorld, StandsStillAtSpeedZero) {
  SimulatorOptions options;
  options.speed = 0;
  const SimulatedWorld world(options, FieldSize{}, kHeightsMm);
  EXPECT_EQ(world.at(5).robots[3].x_mm, world.at(1.79e9).robots[3].x_mm);
}

TEST(SimulatedWorld, CountsIdsUpFromTheFirst) {
  SimulatorOptions options;
  options.robots_yellow = 3;
  options.first_yellow_id = 13;
  options.robots_blue = 2;
  std::vector<int> yellow, blue;
  for (const SimulatedRobot& robot : SimulatedWorld(options, FieldSize{}, kHeightsMm).at(0).robots) {
    (robot.team == Team::kYellow ? yellow : blue).push_back(robot.id);
  }
  EXPECT_THAT(yellow, testing::UnorderedElementsAre(13, 14, 15));
  EXPECT_THAT(blue, testing::UnorderedElementsAre(0, 1));
}

TEST(SimulatedWorld, RefusesMoreThanTheFieldHolds) {
  FieldSize field;
  field.field_length = 1500;
  field.field_width = 1000;
  SimulatorOptions options;
  options.robots_yellow = options.robots_blue = 16;
  try {
    const SimulatedWorld world(options, field, kHeightsMm);
    FAIL() << "32 robots fit";
  } catch (const SettingsError& error) {
    EXPECT_STREQ(
        error.what(),
        "robots_yellow, robots_blue, balls: 32 robots and 1 balls are not allowed on a field of 1500 x 1000 "
        "mm; expected fewer");
  }
}

TEST(SimulatedRobot, HidesWhatLiesBehindItsTopAndItsSides) {
  const SimulatedRobot robot{Team::kBlue, 0, 0, 0, 0, 140};
  const auto is_hidden = [&](double x_mm, double y_mm, double z_mm) {
    return hides(robot, 90, {x_mm, y_mm, z_mm}, {-2000, 0, 4140});
  };
  EXPECT_TRUE(is_hidden(0, 0, 0));
  EXPECT_TRUE(is_hidden(126, 0, 0));
  EXPECT_FALSE(is_hidden(128, 0, 0));  // beyond the area hidden by the top with its flat front
  EXPECT_TRUE(is_hidden(-89, 0, 0));
  EXPECT_FALSE(is_hidden(-91, 0, 0));
  EXPECT_TRUE(is_hidden(0, 89, 0));
  EXPECT_FALSE(is_hidden(0, 92, 0));
  // The sight line crosses the top's plane in front of the robot, and then the robot's side.
  EXPECT_TRUE(is_hidden(35, 89, 0));
  EXPECT_FALSE(is_hidden(70 + 30, 89, 0));
  EXPECT_FALSE(is_hidden(0, 0, 140));
}

SimulatorOptions scattered_options() {
  SimulatorOptions options;
  options.placement = SimulatorPlacement::kScatter;
  options.robots_yellow = options.robots_blue = 11;
  options.balls = 6;
  return options;
}
constexpr double kSlotS = 1.0 / 60;

TEST(SimulatedScatter, IsAFunctionOfOptionsAndSlot) {
  SimulatorOptions options = scattered_options();
  options.distractors = 20;
  options.covered_dots = 4;
  const SimulatedWorld one(options, FieldSize{}, kHeightsMm), same(options, FieldSize{}, kHeightsMm);
  options.seed = 2;
  const SimulatedWorld other(options, FieldSize{}, kHeightsMm);
  const SimulatedScene a = one.at(1000 * kSlotS), b = same.at(1000.4 * kSlotS), c = other.at(1000 * kSlotS),
                       next = one.at(1001 * kSlotS);
  for (std::size_t i = 0; i < a.robots.size(); ++i) {
    EXPECT_EQ(a.robots[i].x_mm, b.robots[i].x_mm);
    EXPECT_EQ(a.robots[i].orientation_rad, b.robots[i].orientation_rad);
    EXPECT_EQ(a.robots[i].covered_dot, b.robots[i].covered_dot);
    EXPECT_NE(a.robots[i].x_mm, c.robots[i].x_mm);
    EXPECT_NE(a.robots[i].x_mm, next.robots[i].x_mm);
  }
  EXPECT_EQ(a.balls[0].x_mm, b.balls[0].x_mm);
  EXPECT_EQ(a.distractors[7].x_mm, b.distractors[7].x_mm);
  EXPECT_NE(a.distractors[7].x_mm, next.distractors[7].x_mm);
}

TEST(SimulatedScatter, TwinsWearThePatternOfTheirTeamsFirst) {
  SimulatorOptions options = scattered_options();
  options.first_blue_id = 3;
  options.twins = 2;
  std::map<std::pair<Team, int>, int> counts;
  for (const auto& robot : SimulatedWorld(options, FieldSize{}, kHeightsMm).at(0).robots)
    ++counts[{robot.team, robot.id}];
  EXPECT_EQ((counts[{Team::kYellow, 0}]), 3);
  EXPECT_EQ((counts[{Team::kBlue, 3}]), 3);
  EXPECT_EQ((counts[{Team::kBlue, 13}]), 1);
  EXPECT_EQ(counts.size(), 18U);
}

TEST(SimulatedScatter, KeepsThingsApartExceptTouchingRobots) {
  for (const double gap_mm : {0.0, 1.0, 20.0}) {
    SimulatorOptions options = scattered_options();
    options.touching = 8;
    options.touching_gap_mm = gap_mm;
    options.distractors = 40;
    const SimulatedWorld world(options, FieldSize{}, kHeightsMm);
    double min_heading = 10, max_heading = -10, min_x = 1e9, max_x = -1e9;
    for (int slot = 0; slot < 40; ++slot) {
      const SimulatedScene scene = world.at(slot * kSlotS);
      ASSERT_EQ(scene.robots.size(), 22U);
      ASSERT_EQ(scene.balls.size(), 6U);
      ASSERT_EQ(scene.distractors.size(), 40U);
      int touching = 0;
      std::set<std::pair<Team, int>> roster;
      for (std::size_t a = 0; a < scene.robots.size(); ++a) {
        const SimulatedRobot& robot = scene.robots[a];
        roster.insert({robot.team, robot.id});
        ASSERT_LE(std::abs(robot.x_mm), 4500 - 90);
        ASSERT_LE(std::abs(robot.y_mm), 3000 - 90);
        min_x = std::min(min_x, robot.x_mm);
        max_x = std::max(max_x, robot.x_mm);
        min_heading = std::min(min_heading, robot.orientation_rad);
        max_heading = std::max(max_heading, robot.orientation_rad);
        for (std::size_t b = 0; b < a; ++b) {
          const double gap =
              distance_mm(robot.x_mm, robot.y_mm, scene.robots[b].x_mm, scene.robots[b].y_mm) - 180;
          if (std::abs(gap - gap_mm) < 1e-9) {
            touching += 2;
          } else {
            ASSERT_GE(gap, kSimulatorClearanceMm);
          }
        }
      }
      ASSERT_EQ(touching, 8);
      ASSERT_EQ(roster.size(), 22U);
      for (std::size_t a = 0; a < scene.balls.size(); ++a) {
        const SimulatedBall& ball = scene.balls[a];
        ASSERT_LE(std::abs(ball.y_mm), 3000 - 21.5);
        for (const SimulatedRobot& robot : scene.robots) {
          ASSERT_GE(distance_mm(robot.x_mm, robot.y_mm, ball.x_mm, ball.y_mm), 90 + 21.5 + 60);
        }
        for (std::size_t b = 0; b < a; ++b) {
          ASSERT_GE(distance_mm(scene.balls[b].x_mm, scene.balls[b].y_mm, ball.x_mm, ball.y_mm), 43 + 60);
        }
        for (const SimulatedDistractor& thing : scene.distractors) {
          ASSERT_GE(distance_mm(thing.x_mm, thing.y_mm, ball.x_mm, ball.y_mm),
                    21.5 + 40 + std::max(thing.length_mm, thing.width_mm) / 2);
        }
      }
    }
    EXPECT_GT(min_heading, -std::numbers::pi);
    EXPECT_LT(min_heading, -3);
    EXPECT_LE(max_heading, std::numbers::pi);
    EXPECT_GT(max_heading, 3);
    EXPECT_LT(min_x, -4300);
    EXPECT_GT(max_x, 4300);
  }
}

TEST(SimulatedScatter, MovesInAStraightLineAboutTheTruthWhileExposed) {
  SimulatorOptions options = scattered_options();
  options.speed = 0.5;
  const SimulatedWorld world(options, FieldSize{}, kHeightsMm);
  // The exposure is longer than a slot: an image shows one slot only.
  std::array<SimulatedScene, 5> moments;
  world.expose(3.0, 0.05, moments);
  const SimulatedScene truth = world.at(3.0);
  bool turns = false;
  for (std::size_t i = 0; i < truth.robots.size(); ++i) {
    const SimulatedRobot &first = moments[0].robots[i], &last = moments[4].robots[i];
    EXPECT_EQ(moments[2].robots[i].x_mm, truth.robots[i].x_mm);
    EXPECT_NEAR((first.y_mm + last.y_mm) / 2, truth.robots[i].y_mm, 1e-9);
    EXPECT_NEAR(distance_mm(first.x_mm, first.y_mm, last.x_mm, last.y_mm), 1000 * 0.04, 1e-6);
    const double turned = std::remainder(last.orientation_rad - first.orientation_rad, 2 * std::numbers::pi);
    EXPECT_LE(std::abs(turned), 1.5 * 0.04);
    turns |= std::abs(turned) > 0.03;
  }
  EXPECT_TRUE(turns);
  EXPECT_NEAR(distance_mm(moments[0].balls[0].x_mm, moments[0].balls[0].y_mm, moments[1].balls[0].x_mm,
                          moments[1].balls[0].y_mm),
              1000 * 0.01, 1e-6);
}

TEST(SimulatedWorld, CoversASideDotOfSomeRobots) {
  for (const auto placement : {SimulatorPlacement::kPaths, SimulatorPlacement::kScatter}) {
    SimulatorOptions options = scattered_options();
    options.placement = placement;
    options.covered_dots = 7;
    const SimulatedWorld world(options, FieldSize{}, kHeightsMm);
    const auto covered = [&](double t_s) {
      std::set<std::tuple<Team, int, int>> out;
      for (const SimulatedRobot& robot : world.at(t_s).robots) {
        if (robot.covered_dot) out.insert({robot.team, robot.id, *robot.covered_dot});
      }
      return out;
    };
    std::set<int> dots;
    for (int slot = 0; slot < 10; ++slot) {
      const auto some = covered(slot * kSlotS);
      EXPECT_EQ(some.size(), 7U);
      for (const auto& [team, id, dot] : some) dots.insert(dot);
    }
    EXPECT_EQ(covered(0) == covered(5), placement == SimulatorPlacement::kPaths);
    EXPECT_GE(*dots.begin(), 0);
    EXPECT_LE(*dots.rbegin(), 3);
    EXPECT_GT(dots.size(), 1U);
  }
}

TEST(SimulatedWorld, DistractorsAreOfAllKindsAndNeverBallLike) {
  std::vector<SimulatedDistractor> all;
  for (int seed = 0; seed < 20; ++seed) {
    SimulatorOptions options;
    options.distractors = 60;
    options.seed = seed;
    const SimulatedWorld still(options, FieldSize{}, kHeightsMm);
    const SimulatedScene now = still.at(0), later = still.at(100);
    for (std::size_t i = 0; i < now.distractors.size(); ++i) {
      EXPECT_EQ(now.distractors[i].x_mm, later.distractors[i].x_mm);
    }
    options.placement = SimulatorPlacement::kScatter;
    const SimulatedScene scene = SimulatedWorld(options, FieldSize{}, kHeightsMm).at(seed);
    all.insert(all.end(), now.distractors.begin(), now.distractors.end());
    all.insert(all.end(), scene.distractors.begin(), scene.distractors.end());
  }
  ASSERT_EQ(all.size(), 20U * 2 * 60);
  std::set<int> paints;
  int discs = 0, triangles = 0, stripes = 0;
  for (const SimulatedDistractor& thing : all) {
    const double least = std::min(thing.length_mm, thing.width_mm);
    const double most = std::max(thing.length_mm, thing.width_mm);
    EXPECT_GE(least, 15);
    EXPECT_LE(most, 250);
    paints.insert(thing.paint);
    if (thing.paint == label::kOrange || thing.paint == paint::kRed) {
      EXPECT_TRUE(least < 28 || most > 65) << least << " x " << most;
    }
    discs += thing.shape == SimulatedDistractor::Shape::kEllipse && least == most;
    triangles += thing.shape == SimulatedDistractor::Shape::kTriangle;
    stripes += thing.shape == SimulatedDistractor::Shape::kRectangle && least * 4 < most;
  }
  EXPECT_EQ(paints.size(), 12U);
  EXPECT_GT(discs, 100);
  EXPECT_GT(triangles, 100);
  EXPECT_GT(stripes, 100);
}

TEST(SimulatedScatter, RefusesMoreThanTheFieldHolds) {
  FieldSize field;
  field.field_length = 1500;
  field.field_width = 1000;
  const auto error_of = [&](const SimulatorOptions& options) -> std::string {
    try {
      const SimulatedWorld world(options, field, kHeightsMm);
    } catch (const SettingsError& error) {
      return error.what();
    }
    return "no error";
  };
  SimulatorOptions options = scattered_options();
  options.robots_yellow = options.robots_blue = 16;
  EXPECT_EQ(
      error_of(options),
      "robots_yellow, robots_blue, balls: 32 robots and 6 balls are not allowed on a field of 1500 x 1000 "
      "mm; expected fewer");
  options.robots_yellow = options.robots_blue = 8;
  EXPECT_EQ(error_of(options), "no error");
  options.distractors = 60;
  EXPECT_EQ(error_of(options),
            "distractors: 60 are not allowed on a field of 1500 x 1000 mm; expected fewer");
  options.hidden_balls = 1;
  EXPECT_EQ(error_of(options),
            "hidden_balls: 1 is not allowed without a camera to hide them from; expected 0");
}

}  // namespace
}  // namespace sslv::simulator_world_test
