// SPDX-License-Identifier: Apache-2.0
#include "capture/simulator_world.h"

#include "base/error.h"

#include <cmath>
#include <numbers>
#include <string>

#include <gmock/gmock.h>

namespace sslv {
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
  EXPECT_GE(nearest_robots, 180 + SimulatedWorld::kClearanceMm);
  EXPECT_GE(nearest_ball, 90 + 21.5 + SimulatedWorld::kClearanceMm);
  // The hard cases of a match do occur.
  EXPECT_LT(nearest_robots, 210);
  EXPECT_LT(nearest_ball, 150);
}

TEST(SimulatedWorld, MovesSmoothlyAndTurns) {
  const SimulatedWorld world(SimulatorOptions{}, FieldSize{}, kHeightsMm);
  constexpr double kStepS = 0.02;
  double most_moved_mm = 0, most_turned_rad = 0, travelled_mm = 0;
  double least_heading = 10, most_heading = -10;
  for (int i = 0; i < 5000; ++i) {
    const SimulatedScene a = world.at(100 + i * kStepS), b = world.at(100 + (i + 1) * kStepS);
    for (std::size_t r = 0; r < a.robots.size(); ++r) {
      const auto &from = a.robots[r], &to = b.robots[r];
      most_moved_mm = std::max(most_moved_mm, distance_mm(from.x_mm, from.y_mm, to.x_mm, to.y_mm));
      const double turned = std::remainder(to.orientation_rad - from.orientation_rad, 2 * std::numbers::pi);
      most_turned_rad = std::max(most_turned_rad, std::abs(turned));
    }
    travelled_mm += distance_mm(a.robots[0].x_mm, a.robots[0].y_mm, b.robots[0].x_mm, b.robots[0].y_mm);
    least_heading = std::min(least_heading, a.robots[0].orientation_rad);
    most_heading = std::max(most_heading, a.robots[0].orientation_rad);
  }
  EXPECT_LT(most_moved_mm, 3000 * kStepS);
  EXPECT_LT(most_turned_rad, 8 * kStepS);
  EXPECT_GT(travelled_mm, 100 * 200);
  EXPECT_GT(least_heading, -std::numbers::pi);
  EXPECT_LE(most_heading, std::numbers::pi);
  EXPECT_LT(least_heading, -2.5);
  EXPECT_GT(most_heading, 2.5);
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

}  // namespace
}  // namespace sslv
