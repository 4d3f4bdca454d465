// SPDX-License-Identifier: Apache-2.0
#include "services/field/field_now.h"

#include "services/field/field_report.h"

#include <memory>

#include <gmock/gmock.h>

namespace sslv::field_now_test {
namespace {

TrackedKick kick_with(int number) {
  TrackedKick kick;
  kick.number = number;
  kick.t_s = 100.0 + number;
  kick.place_mm = {10.0 * number, 0};
  kick.velocity_mm_s = {3000, 0, 0};
  return kick;
}

TEST(FieldNow, IsWhatWasTracked) {
  TrackedField tracked;
  tracked.number = 7;
  tracked.t_s = 1000.25;
  TrackedRobot robot;
  robot.name = {Team::kBlue, 12};
  robot.place_mm = {1, 2};
  robot.velocity_mm_s = {3, 4};
  robot.orientation_rad = 0.5;
  robot.visibility = 0.25;
  tracked.robots.push_back(robot);
  TrackedBall ball;
  ball.place_mm = {5, 6, 7};
  ball.velocity_mm_s = {8, 9, 10};
  tracked.balls.push_back(ball);
  tracked.kick = kick_with(3);
  tracked.kick->robot = RobotName{Team::kYellow, 4};

  const auto now = std::make_unique<FieldNow>();
  EXPECT_TRUE(tracked_of(*now).robots.empty());
  EXPECT_FALSE(tracked_of(*now).kick);
  write_now(tracked, *now);
  const TrackedField read = tracked_of(*now);
  EXPECT_EQ(read.number, 7U);
  EXPECT_EQ(read.t_s, 1000.25);
  ASSERT_EQ(read.robots.size(), 1U);
  EXPECT_EQ(read.robots[0].name, robot.name);
  EXPECT_EQ(read.robots[0].place_mm, robot.place_mm);
  EXPECT_EQ(read.robots[0].visibility, 0.25);
  ASSERT_EQ(read.balls.size(), 1U);
  EXPECT_EQ(read.balls[0].place_mm, ball.place_mm);
  ASSERT_TRUE(read.kick);
  EXPECT_EQ(read.kick->number, 3);
  EXPECT_EQ(read.kick->robot, tracked.kick->robot);
}

TEST(FieldNow, KeepsTheNewestEstimateOfTheLastKicks) {
  const auto now = std::make_unique<FieldNow>();
  TrackedField tracked;
  for (int number = 1; number <= 20; ++number) {
    tracked.kick = kick_with(number);
    write_now(tracked, *now);
  }
  tracked.kick->place_mm = {-1, -1};  // the newest kick is now known better
  write_now(tracked, *now);
  const auto kicks = kicks_of(*now);
  ASSERT_EQ(kicks.size(), FieldNow::kKicks);
  for (std::size_t i = 0; i < kicks.size(); ++i) EXPECT_EQ(kicks[i].number, 13 + static_cast<int>(i));
  EXPECT_EQ(kicks.back().place_mm, Eigen::Vector2d(-1, -1));
}

TEST(FieldNow, TheNumberOfRobotsIsLimited) {
  const auto now = std::make_unique<FieldNow>();
  TrackedField tracked;
  tracked.robots.resize(1000);
  tracked.balls.resize(1000);
  write_now(tracked, *now);
  EXPECT_EQ(tracked_of(*now).robots.size(), FieldNow::kMaxRobots);
  EXPECT_EQ(tracked_of(*now).balls.size(), FieldNow::kMaxBalls);
}

TEST(CameraPairs, NameTheOutlierFirst) {
  const auto agreement = std::make_unique<AgreementNow>();
  const auto add = [&](int camera, int other, float off_mm) {
    for (int i = 0; i < 4; ++i)
      agreement->differences[agreement->difference_count++] = {camera,
                                                               other,
                                                               250.0F + 500.0F * static_cast<float>(i),
                                                               250,
                                                               off_mm + static_cast<float>(i) * 0.1F,
                                                               0,
                                                               100,
                                                               1000};
  };
  add(0, 1, 1);
  add(0, 2, 7);
  add(1, 2, 8);
  const auto pairs = pairs_of(*agreement);
  ASSERT_EQ(pairs.size(), 3U);
  EXPECT_EQ(pairs[1].camera, 2);
  EXPECT_EQ(pairs[1].other, 0);
  EXPECT_NEAR(pairs[1].off_mm, 7.2, 0.11);
  EXPECT_EQ(pairs[1].worst_mm, Eigen::Vector2d(1750, 250));
  EXPECT_EQ(pairs[2].camera, 2);

  FieldFacts facts;
  facts.config = std::make_shared<Config>();
  facts.agreement = *agreement;
  HealthReport report;
  report_field(facts, report);
  ASSERT_EQ(report.alerts.size(), 2U) << "a millimetre is none";
  EXPECT_THAT(report.alerts[0].title,
              testing::StartsWith("Camera 2 differs from camera 0 by 7 mm, most at (1750, 250) mm"));
  EXPECT_EQ(report.alerts[0].fix,
            "Was one of them bumped, or is a team's robot height wrong? Calibrate it again, or both of them "
            "together.");

  AgreementHistory history;
  history.add({{.camera = 0, .other = 2, .off_mm = 1.1, .parts = 4, .worst_mm = {0, 0}}}, 1000);
  history.add(pairs, 1010);
  facts.history = &history;
  report = {};
  report_field(facts, report);
  EXPECT_EQ(report.alerts.at(0).fix,
            "Was one of them bumped, or is a team's robot height wrong? Before, it was 1.1 mm. Calibrate it "
            "again, or both of them together.");
}

}  // namespace
}  // namespace sslv::field_now_test
