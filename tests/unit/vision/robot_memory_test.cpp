// SPDX-License-Identifier: Apache-2.0
#include "vision/robot_memory.h"

#include <array>
#include <cmath>
#include <numbers>

#include <gmock/gmock.h>

namespace sslv::robot_memory_test {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr double kPi = std::numbers::pi;

Robot robot_at(Team team, int id, double x_mm, double y_mm, double angle_rad) {
  return {team, id, x_mm, y_mm, angle_rad, 140, 0, 0, 1};
}

TEST(RobotMemory, ExpectsARobotWhereItStoodUntilItIsSeenTwice) {
  RobotMemory memory;
  EXPECT_THAT(memory.entries(), IsEmpty());
  memory.remember({{robot_at(Team::kBlue, 4, 100, -200, 0.5)}}, 10);
  ASSERT_THAT(memory.entries(), SizeIs(1));
  const PatternPose expected = memory.entries()[0].at(10.1);
  EXPECT_EQ(expected.x_mm, 100);
  EXPECT_EQ(expected.y_mm, -200);
  EXPECT_EQ(expected.angle_rad, 0.5);
}

TEST(RobotMemory, ThenPredictsItsMotion) {
  RobotMemory memory;
  memory.remember({{robot_at(Team::kBlue, 4, 100, -200, 0.5)}}, 10);
  memory.remember({{robot_at(Team::kBlue, 4, 120, -230, 0.6)}}, 10.01);
  ASSERT_THAT(memory.entries(), SizeIs(1));
  const PatternPose expected = memory.entries()[0].at(10.03);
  EXPECT_NEAR(expected.x_mm, 160, 1e-6);
  EXPECT_NEAR(expected.y_mm, -290, 1e-6);
  EXPECT_NEAR(expected.angle_rad, 0.8, 1e-6);
}

TEST(RobotMemory, WithARollingShutterARobotWasElsewhereAtTheFramesTime) {
  // Rows 0 to 100 are exposed from 10 ms before the frame's time to 10 ms after.
  const RowTimes rows(0.02, {}, 101);
  EXPECT_NEAR(rows.delay_s(50), 0, 1e-12);
  EXPECT_NEAR(rows.delay_s(75), 0.005, 1e-12);
  const auto place = [](double t) {  // accelerates
    return std::array{1000 * t + 2000 * t * t, -500 * t, 3 * t};
  };
  RobotMemory memory;
  for (int frame = 0; frame < 4; ++frame) {
    const double now_s = 10 + 0.016 * frame, row = 100 - 10 * frame;
    const auto seen = place(now_s + rows.delay_s(row) - 10), there = place(now_s - 10);
    RobotList robots{{robot_at(Team::kBlue, 4, seen[0], seen[1], seen[2])}};
    robots.robots[0].pixel_y = row;
    memory.remember(robots, now_s, rows);
    memory.move_to_frame(robots);
    const Robot& moved = robots.robots[0];
    if (frame == 0) {
      EXPECT_EQ(moved.x_mm, seen[0]) << "its speed is not known";
      continue;
    }
    EXPECT_NEAR(moved.x_mm, there[0], frame == 1 ? 0.5 : 1e-6);
    EXPECT_NEAR(moved.y_mm, there[1], 1e-6);
    EXPECT_NEAR(moved.orientation_rad, there[2], 1e-9);
  }
}

TEST(RobotMemory, ATileKnowsWhichRowsOfTheWholePictureItHas) {
  const WholePicture whole{200, 101, 0, 40};
  const RowTimes rows(0.02, whole, 50);
  EXPECT_NEAR(rows.delay_s(10), 0, 1e-12);
  EXPECT_NEAR(rows.s_per_row(), 0.0002, 1e-12);
  EXPECT_FALSE(RowTimes().rolls());
  EXPECT_EQ(RowTimes().delay_s(1000), 0);
}

TEST(RobotMemory, TurnsTheShortWay) {
  RobotMemory memory;
  memory.remember({{robot_at(Team::kYellow, 1, 0, 0, kPi - 0.05)}}, 10);
  memory.remember({{robot_at(Team::kYellow, 1, 0, 0, -kPi + 0.05)}}, 10.01);
  const double expected = memory.entries()[0].at(10.02).angle_rad;
  EXPECT_NEAR(std::remainder(expected - (-kPi + 0.15), 2 * kPi), 0, 1e-6);
}

TEST(RobotMemory, AMovedRobotStandsAtItsNewPlace) {
  RobotMemory memory;
  memory.remember({{robot_at(Team::kBlue, 4, 0, 0, 0)}}, 10);
  memory.remember({{robot_at(Team::kBlue, 4, 2000, 0, 2)}}, 10.016);
  EXPECT_EQ(memory.entries()[0].at(10.1).x_mm, 2000);
  EXPECT_EQ(memory.entries()[0].at(10.1).angle_rad, 2);
}

TEST(RobotMemory, KnowsTeamsAndIdsApart) {
  RobotMemory memory;
  memory.remember({{robot_at(Team::kBlue, 4, 0, 0, 0), robot_at(Team::kYellow, 4, 500, 0, 0),
                    robot_at(Team::kBlue, 5, 900, 0, 0)}},
                  10);
  EXPECT_THAT(memory.entries(), SizeIs(3));
}

TEST(RobotMemory, OfTwoWithTheSameIdTheMoreConfidentCounts) {
  // Lists are sorted by falling confidence.
  RobotMemory memory;
  memory.remember({{robot_at(Team::kBlue, 4, 0, 0, 0), robot_at(Team::kBlue, 4, 900, 0, 0)}}, 10);
  memory.remember({{robot_at(Team::kBlue, 4, 1, 0, 0), robot_at(Team::kBlue, 4, 901, 0, 0)}}, 10.01);
  ASSERT_THAT(memory.entries(), SizeIs(1));
  EXPECT_EQ(memory.entries()[0].x_mm, 1);
}

TEST(RobotMemory, ForgetsWhatIsOld) {
  RobotMemory memory;
  memory.remember({{robot_at(Team::kBlue, 4, 0, 0, 0)}}, 10);
  memory.remember({{robot_at(Team::kBlue, 5, 900, 0, 0)}}, 10.05);
  memory.forget(10.09, 0.1);
  EXPECT_THAT(memory.entries(), SizeIs(2));
  memory.forget(10.12, 0.1);
  ASSERT_THAT(memory.entries(), SizeIs(1));
  EXPECT_EQ(memory.entries()[0].id, 5);
  memory.forget(10.12, 0);
  EXPECT_THAT(memory.entries(), IsEmpty());
}

TEST(RobotMemory, ForgetsAllWhenTimeGoesBackOrStandsStill) {
  for (const double now_s : {10.0, 9.9, -1e9}) {
    RobotMemory memory;
    memory.remember({{robot_at(Team::kBlue, 4, 0, 0, 0)}}, 10);
    memory.forget(now_s, 0.1);
    EXPECT_THAT(memory.entries(), IsEmpty()) << now_s;
  }
}

TEST(RobotMemory, TwoPicturesOfOneMomentGiveNoSpeed) {
  RobotMemory memory;
  memory.remember({{robot_at(Team::kBlue, 4, 0, 0, 0)}}, 10);
  memory.remember({{robot_at(Team::kBlue, 4, 5, 0, 0)}}, 10);
  const PatternPose expected = memory.entries()[0].at(11);
  EXPECT_TRUE(std::isfinite(expected.x_mm));
  EXPECT_LE(std::abs(expected.x_mm), 5);
}

}  // namespace
}  // namespace sslv::robot_memory_test
