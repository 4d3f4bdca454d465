// SPDX-License-Identifier: Apache-2.0
#include "tracking/smoother.h"

#include "worlds/ours.h"
#include "worlds/score.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <gtest/gtest.h>

namespace sslv::smoother_test {
namespace {

constexpr double kLag_s = 0.25, kPeriod_s = 0.0125;

/// One robot and one ball, seen by one camera.
class OneOfEach : public testing::Test {
 protected:
  void see(double x_mm, bool shows_ball = true, bool shows_robot = true) {
    Observations seen;
    if (shows_robot)
      seen.robots.push_back({kName, 0, t_s_, 2e-5, {x_mm, 0}, 0, Eigen::Matrix2d::Identity() * 0.01, 1e-3});
    if (shows_ball) seen.balls.push_back({t_s_, {0, 0, 4000}, {x_mm, 500}, 0.3, 21.5, 1e9});
    smoother_.add(seen, t_s_);
    if (!smoother_.at(field_)) field_ = {};
    t_s_ += kPeriod_s;
  }

  static constexpr RobotName kName{Team::kBlue, 3};
  Smoother smoother_{kLag_s};
  TrackedField field_;
  double t_s_ = 1e9;
};

TEST(Smoother, IsMoreAccurateThanTheFilter) {
  worlds::WorldOptions options;
  options.seed = 41;
  options.duration_s = 12;
  const worlds::World world(options);
  worlds::Ours ours;
  const worlds::Score at_once = worlds::score(world, ours), later = worlds::score_later(world, kLag_s);
  EXPECT_LE(later.errors.at("robot velocity").rms(), 10);
  EXPECT_LE(later.errors.at("robot velocity").rms(), 0.5 * at_once.errors.at("robot velocity").rms());
  EXPECT_LE(later.errors.at("robot turn").rms(), 0.1);
  EXPECT_GE(later.errors.at("robot place").count(), at_once.errors.at("robot place").count() * 9 / 10);
}

TEST(Smoother, ReportsEveryKickHoweverSoonTheNextFollows) {
  worlds::WorldOptions options;
  options.seed = 46;  // with three kicks less than two seconds after the previous one
  options.duration_s = 20;
  const worlds::World world(options);
  constexpr double kLong_s = 2;
  worlds::Ours ours;
  Smoother smoother(kLong_s);
  TrackedField later;
  std::set<int> at_once, told;
  for (const worlds::WorldImage& image : world.images()) {
    ours.add(image);
    const auto& kick = ours.tracker().kick();
    if (kick && image.arrival_s < options.duration_s - kLong_s - 0.2) at_once.insert(kick->number);
    smoother.add(ours.observations(), image.arrival_s);
    if (!smoother.at(later) || !later.kick) continue;
    told.insert(later.kick->number);
    EXPECT_LE(later.kick->t_s, later.t_s);
  }
  EXPECT_GE(at_once.size(), 4U);
  for (const int number : at_once) EXPECT_TRUE(told.count(number)) << number;
}

TEST_F(OneOfEach, IsShownFromTheFirstMeasurement) {
  const double began_s = t_s_;
  double first_s = 0;
  for (int i = 0; i < 60 && first_s == 0; ++i) {
    see(20.0 * i);
    if (!field_.robots.empty()) first_s = field_.t_s;
  }
  EXPECT_NEAR(first_s, began_s, kPeriod_s);
  EXPECT_NEAR(field_.robots.at(0).velocity_mm_s.x(), 20 / kPeriod_s, 5) << "what came later tells it";
}

TEST_F(OneOfEach, IsInterpolatedWhileUnseen) {
  int i = 0;
  for (; i < 80; ++i) see(10.0 * i);
  for (; i < 92; ++i) see(10.0 * i, false);
  double worst_mm = 0, least = 1;
  for (; i < 130; ++i) {
    see(10.0 * i);
    ASSERT_EQ(field_.balls.size(), 1U);
    const double truth_mm = 10.0 * (field_.t_s - 1e9) / kPeriod_s;
    worst_mm = std::max(worst_mm, std::abs(field_.balls[0].place_mm.x() - truth_mm));
    least = std::min(least, field_.balls[0].visibility);
  }
  EXPECT_LE(worst_mm, 10);
  EXPECT_LT(least, 1) << "it was not seen all the time";
}

TEST_F(OneOfEach, ARobotThatWasCarriedAwayWasWhereItWasUntilThen) {
  int i = 0;
  for (; i < 80; ++i) see(0);
  for (; i < 128; ++i) see(0, false, false);  // for longer than a robot counts as hidden
  for (; i < 200; ++i) {
    see(3000, false);
    for (const TrackedRobot& robot : field_.robots) {
      if (robot.visibility < 0.9) continue;
      const double then = (field_.t_s - 1e9) / kPeriod_s;  // in images since the start
      EXPECT_NEAR(robot.place_mm.x(), then < 127.5 ? 0 : 3000, 2) << then;
    }
  }
  ASSERT_EQ(field_.robots.size(), 1U);
}

TEST_F(OneOfEach, IsNotShownEarlierAfterAMisreadId) {
  int i = 0;
  see(0, false);
  for (++i; i < 60; ++i) see(0, true, false);
  for (; i < 120; ++i) {
    see(3000, false);
    EXPECT_TRUE(field_.t_s > 1e9 + 59.5 * kPeriod_s || field_.robots.empty()) << field_.t_s;
  }
  ASSERT_EQ(field_.robots.size(), 1U);
}

TEST_F(OneOfEach, GoesOnWhenNothingIsSeen) {
  for (int i = 0; i < 80; ++i) see(0);
  const double before_s = field_.t_s;
  for (int i = 0; i < 100; ++i) see(0, false, false);
  EXPECT_NEAR(field_.t_s, before_s + 100 * kPeriod_s, 1e-5);
  EXPECT_TRUE(field_.robots.empty());
  EXPECT_TRUE(field_.balls.empty());
}

TEST_F(OneOfEach, BeginsAgainWhenTheClockIsSetBack) {
  for (int i = 0; i < 60; ++i) see(0);
  t_s_ -= 3600;
  for (int i = 0; i < 60; ++i) see(2000);
  ASSERT_EQ(field_.robots.size(), 1U);
  EXPECT_NEAR(field_.robots[0].place_mm.x(), 2000, 1);
}

}  // namespace
}  // namespace sslv::smoother_test
