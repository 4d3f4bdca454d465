// SPDX-License-Identifier: Apache-2.0
#include "tracking/tracker.h"

#include "tracking/track.h"
#include "worlds/ours.h"
#include "worlds/score.h"

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace sslv::tracker_test {
namespace {

using worlds::Ours, worlds::Score, worlds::World, worlds::WorldOptions;

WorldOptions short_world(std::uint64_t seed) {
  WorldOptions options;
  options.seed = seed;
  options.duration_s = 20;
  return options;
}

TEST(Tracker, RobotsAreWhereTheyAreWhenThePacketLeaves) {
  const World world(short_world(21));
  Ours ours;
  const Score score = worlds::score(world, ours);
  EXPECT_EQ(score.counts.count("robots missing (images)"), 0U);
  EXPECT_LE(score.errors.at("robot velocity").rms(), 25);
  EXPECT_LE(score.errors.at("robot velocity").quantile(0.5), 9);
  EXPECT_LE(score.errors.at("robot velocity standing").quantile(0.5), 1);
  EXPECT_LE(score.errors.at("robot orientation deg").rms(), 0.35);
  EXPECT_LE(score.errors.at("robot turn").rms(), 0.4);
  EXPECT_LE(score.errors.at("jump at border").quantile(0.99), 0.8);
  EXPECT_LE(score.errors.at("set-up ms").rms(), 30);
}

TEST(Tracker, LearnsHowMuchCamerasClocksDiffer) {
  const World world(short_world(22));
  Ours ours;
  for (const auto& image : world.images()) ours.add(image);
  const auto& agreement = ours.agreement();
  for (int camera = 1; camera < 4; ++camera) {
    const auto& cameras = world.cameras();
    const double differs_s =
        cameras[static_cast<std::size_t>(camera)].clock_offset_s - cameras[0].clock_offset_s;
    EXPECT_NEAR(agreement.time_offset_s(camera) - agreement.time_offset_s(0), differs_s, 0.05e-3);
  }
}

TEST(Tracker, LearnsHowHighRobotsAre) {
  WorldOptions options = short_world(23);
  options.robot_height_spread_mm = 8;
  options.robot_bias_mm = options.floor_bias_mm = 0;
  const World world(options);
  Ours ours;
  for (const auto& image : world.images()) ours.add(image);
  int sure = 0;
  for (int i = 0; i < options.robots; ++i) {
    const auto height = ours.agreement().height_of({World::team_of(i), World::id_of(i)});
    ASSERT_TRUE(height);
    const double truth_mm = world.height_of(i) - World::kRobotHeightMm;
    EXPECT_NEAR(height->more_mm, truth_mm, 0.5 + 3 * height->sigma_mm) << i;
    if (height->sigma_mm < 1.5) ++sure;
  }
  EXPECT_GE(sure, options.robots * 3 / 4);
}

TEST(Tracker, TheBallIsWhereItIsWhenThePacketLeaves) {
  WorldOptions options = short_world(24);
  options.duration_s = 30;
  const World world(options);
  Ours ours;
  Score score = worlds::score(world, ours);
  EXPECT_LE(score.errors.at("ball rolling").quantile(0.5), 2);
  EXPECT_LE(score.errors.at("ball sliding").quantile(0.5), 2);
  EXPECT_LE(score.errors.at("ball held").quantile(0.5), 3);
  EXPECT_LE(score.errors.at("kick published ms").quantile(0.5), 50);
  EXPECT_LE(score.errors.at("kick speed at 100 ms").rms(), 30);
  EXPECT_EQ(score.counts["false kicks"], 0);
  EXPECT_EQ(score.counts["kicks missed"], 0);
  EXPECT_LE(score.counts["ball off while seen (s)"], 0.03 * score.counts["ball seen (s)"]);
}

TEST(Tracker, ASecondBallThatLiesStillTakesNothingFromTheFirst) {
  WorldOptions options = short_world(25);
  options.has_second_ball = true;
  const World world(options);
  Ours ours;
  Score score = worlds::score(world, ours);
  EXPECT_LE(score.errors.at("ball rolling").quantile(0.5), 2);
  EXPECT_LE(score.counts["ball off while seen (s)"], 0.03 * score.counts["ball seen (s)"]);
}

TEST(Tracker, SomethingOrangeOnARobotIsNoBall) {
  WorldOptions options = short_world(27);
  options.has_ball_on_robot = true;
  const World world(options);
  Ours ours;
  Score score = worlds::score(world, ours);
  EXPECT_LE(score.counts["ball off while seen (s)"], 0.01 * score.counts["ball seen (s)"]);
  EXPECT_EQ(score.counts["kicks missed"], 0);
}

TEST(Tracker, PatternsThatAreMisreadAreNoRobots) {
  WorldOptions options = short_world(28);
  options.misread_share = 0.005;
  const World world(options);
  Ours ours;
  Score score = worlds::score(world, ours);
  EXPECT_EQ(score.counts["ghosts of robots"], 0);
  EXPECT_EQ(score.counts["robots missing (images)"], 0);
}

TEST(Tracker, TwoRobotsWithOneIdMakeNoThird) {
  WorldOptions options = short_world(29);
  options.has_twin = true;
  const World world(options);
  Ours ours;
  Score score = worlds::score(world, ours);
  EXPECT_EQ(score.counts["ghosts of robots"], 0);
}

TEST(Tracker, HandsAndShirtsAreHardlyEverTakenForTheBall) {
  WorldOptions options = short_world(30);
  options.hands_share = 0.5;
  const World world(options);
  Ours ours;
  Score score = worlds::score(world, ours);
  EXPECT_EQ(score.counts["ghosts of robots"], 0);
  EXPECT_LE(score.counts["ball off while seen (s)"], 0.03 * score.counts["ball seen (s)"]);
}

TEST(Tracker, RobotsThatCollideAreSoonKnownAgain) {
  WorldOptions options = short_world(31);
  options.robots_collide = true;
  const World world(options);
  Ours ours;
  const Score score = worlds::score(world, ours);
  EXPECT_GE(score.errors.at("collision ms").count(), 50U);
  EXPECT_LE(score.errors.at("collision ms").rms(), 80);
}

TEST(Tracker, TheBallThatIsPlayedComesFirst) {
  WorldOptions options = short_world(26);
  options.has_second_ball = true;
  const World world(options);
  Ours ours;
  for (const auto& image : world.images()) {
    ours.add(image);
    TrackedField field;
    ours.tracker().at(image.arrival_s, field);
    const auto played = ours.ball(image.arrival_s);
    if (!played) continue;
    ASSERT_FALSE(field.balls.empty());
    EXPECT_EQ(field.balls.front().place_mm, played->place_mm);
    EXPECT_GE(played->visibility, 0);
    EXPECT_LE(played->visibility, 1);
  }
}

/// One robot, seen by one camera.
class OneRobot : public testing::Test {
 protected:
  void see(double x_mm) {
    Observations seen;
    seen.robots.push_back({kName, 0, t_s_, 2e-5, {x_mm, 0}, 0, Eigen::Matrix2d::Identity() * 0.01, 1e-3});
    tracker_.add(seen);
    t_s_ += 0.0125;
  }
  std::optional<TrackedRobot> now() const { return tracker_.robot(kName, t_s_); }

  static constexpr RobotName kName{Team::kBlue, 3};
  Tracker tracker_;
  double t_s_ = 1e9;
};

TEST_F(OneRobot, GoesOnWithoutBeingSeenAndIsGoneAfterHalfASecond) {
  for (int i = 0; i < 80; ++i) see(25.0 * i);
  const double seen = now()->visibility;
  t_s_ += 0.2;
  ASSERT_TRUE(now());
  EXPECT_NEAR(now()->place_mm.x(), 25.0 * 79 + 2000 * 0.2125, 30);
  EXPECT_LT(now()->visibility, seen - 0.3);
  t_s_ += 0.3;
  EXPECT_FALSE(now());
  EXPECT_FALSE(tracker_.robot({Team::kYellow, 3}, t_s_));
}

TEST_F(OneRobot, IsNotDuplicatedWhenThreeCamerasSeeItsIdElsewhere) {
  for (int i = 0; i < 80; ++i) see(1000);
  for (int i = 0; i < 100; ++i) {
    see(1000);
    for (int camera = 1; camera <= 3; ++camera) {
      Observations seen;
      seen.robots.push_back(
          {kName, camera, t_s_, 2e-5, {-2000, 0}, 0, Eigen::Matrix2d::Identity() * 0.01, 1e-3});
      tracker_.add(seen);
    }
    ASSERT_NEAR(now()->place_mm.x(), 1000, 1) << i;
  }
  // Then the first robot is gone, and only the other one is seen.
  for (int i = 0; i < 10; ++i) see(-2000);
  EXPECT_NEAR(now()->place_mm.x(), 1000, 1) << "it is hidden";
  for (int i = 0; i < 40; ++i) see(-2000);
  EXPECT_NEAR(now()->place_mm.x(), -2000, 1);
}

/// One robot, seen by a camera of this computer and by one of another computer.
class RobotOfTwoComputers : public OneRobot {
 protected:
  void they_see(double x_mm) {
    Observations theirs;
    theirs.robots.push_back(
        {kName, 1, t_s_, 2e-5, {x_mm, 0}, 0, Eigen::Matrix2d::Identity(), 0.009, 140, true});
    tracker_.add(theirs);
    t_s_ += 0.0125;
  }
  /// The other computer sees it; this computer's camera does not.
  void only_they_see(double x_mm) {
    tracker_.look(0, t_s_);
    they_see(x_mm);
  }
  double x_mm() const { return now().value().place_mm.x(); }
};

TEST_F(RobotOfTwoComputers, StaysWhereASlowCameraOfThisOneSeesIt) {
  for (int i = 0; i < 40; ++i) see(1000);
  for (int image = 0; image < 80; ++image) {
    see(1000);
    for (int i = 0; i < 5; ++i) {  // 13 images a second
      they_see(-2000);
      ASSERT_NEAR(x_mm(), 1000, 1) << image;
    }
  }
}

TEST_F(RobotOfTwoComputers, IgnoresTheOtherComputersWrongPlace) {
  for (int i = 0; i < 40; ++i) see(750 + 12.5 * i);
  for (int image = 0; image < 45; ++image) {
    const double true_mm = 1250 + 6 * 12.5 * image;
    see(true_mm);
    for (int i = 0; i < 5; ++i) {
      they_see(3000);
      ASSERT_NEAR(x_mm(), true_mm + 12.5 * (i + 2), image < 40 ? 200 : 5) << image << " " << i;
    }
  }
}

TEST_F(RobotOfTwoComputers, IsThereAtOnceWhenThisOnesCamerasSeeAgain) {
  for (const double blind_s : {0.1, 0.3, 0.45}) {
    tracker_ = {};
    for (int i = 0; i < 40; ++i) {
      see(1000);
      they_see(1300);
    }
    ASSERT_NEAR(x_mm(), 1000, 1);
    for (double passed_s = 0; passed_s < blind_s; passed_s += 0.0125) only_they_see(1300);
    for (int i = 0; i < 40; ++i) {
      see(1000);
      ASSERT_NEAR(x_mm(), 1000, i < 1 ? 400 : 1) << blind_s;
      they_see(1300);
    }
  }
}

TEST_F(RobotOfTwoComputers, IsNotPulledWhileThisOnesCamerasAreHeldUp) {
  for (const double blind_s : {0.05, 0.1, 0.2, 0.45}) {
    for (const double off_mm : {150.0, 400.0, 550.0, 3000.0}) {
      tracker_ = {};
      for (int i = 0; i < 40; ++i) see(1000);
      t_s_ += blind_s;
      they_see(1000 + off_mm);
      ASSERT_NEAR(x_mm(), 1000, 1) << blind_s << " " << off_mm;
    }
  }
}

TEST_F(RobotOfTwoComputers, IsNotTakenWhileThisOnesCamerasTakeFewImages) {
  for (const double interval_s : {0.15, 0.4, 0.7}) {
    tracker_ = {};
    for (int i = 0; i < 40; ++i) see(1000);
    for (int image = 0; image < 60; ++image) {
      for (double passed_s = 0; passed_s < interval_s; passed_s += 0.0125) {
        they_see(1300);
        if (now()) {
          ASSERT_NEAR(x_mm(), 1000, 1) << interval_s << " " << image;
        }
      }
      see(1000);
    }
  }
}

TEST_F(RobotOfTwoComputers, IsLeftToTheOtherOneWhenThisOnesCamerasAreGone) {
  for (int i = 0; i < 40; ++i) see(1000);
  for (int i = 0; i < 40; ++i) {
    they_see(1000);
    ASSERT_NEAR(x_mm(), 1000, 1) << i;
  }
  for (int i = 0; i < 150; ++i) they_see(1000 + 25 * i);  // for two seconds, either camera may be right
  for (int i = 150; i < 160; ++i) {
    they_see(1000 + 25 * i);
    EXPECT_NEAR(x_mm(), 1000 + 25 * (i + 1), 5) << i;
  }
}

TEST_F(RobotOfTwoComputers, ReturnsToThisComputersPlaceAfterALongCameraStall) {
  for (const double interval_s : {0.0125, 0.2}) {
    tracker_ = {};
    for (int i = 0; i < 40; ++i) see(1000);
    for (int i = 0; i < 300; ++i) they_see(-2000);
    EXPECT_NEAR(x_mm(), -2000, 1);
    for (int image = 0; image < 10; ++image) {
      see(1000);
      for (double passed_s = 0; passed_s < interval_s; passed_s += 0.0125) {
        they_see(-2000);
        if (now()) {  // at first the track restarts
          ASSERT_NEAR(x_mm(), 1000, 1) << interval_s << " " << image;
        }
      }
    }
    EXPECT_TRUE(now());
  }
}

TEST_F(RobotOfTwoComputers, DrivesOnToWhereOnlyTheOtherOneSeesIt) {
  for (int i = 0; i < 80; ++i) {
    see(1000 + 40 * i);
    they_see(-2000);
    if (i < 5) continue;  // not yet shown
    ASSERT_NEAR(x_mm(), 1000 + 40 * (i + 1), 1) << i;
  }
  for (int i = 0; i < 80; ++i) {
    only_they_see(4200 + 20 * i + 20);  // calibrations differ
    ASSERT_NEAR(x_mm(), 4200 + 20 * (i + 1), 30) << i;
  }
  // This computer's cameras have not seen the robot for a while: the other computer may be right.
  for (int i = 0; i < 20; ++i) only_they_see(-2000);
  EXPECT_NEAR(x_mm(), -2000, 1);
}

/// The robot has the maximum speed and acceleration, and the cameras' calibrations differ.
TEST_F(RobotOfTwoComputers, IsNotLostWhenItTurnsRoundWhereOnlyTheOtherOneSeesIt) {
  for (const double acceleration_mm_s2 : {-6500.0, 6500.0}) {
    tracker_ = {};
    for (int i = 0; i < 80; ++i) {
      see(1000 + 37.5 * i);
      t_s_ += 0.0025;  // 2500 mm/s
    }
    const double from_mm = 1000 + 37.5 * 80;
    for (int i = 0; i < 40; ++i) {
      const double passed_s = 0.0125 * i, there_mm = from_mm + 2500 * passed_s;
      const double true_mm = there_mm + acceleration_mm_s2 / 2 * passed_s * passed_s;
      only_they_see(true_mm + 40);
      ASSERT_NEAR(x_mm(), true_mm + (2500 + acceleration_mm_s2 * passed_s) * 0.0125, 120)
          << acceleration_mm_s2 << " " << i;
    }
  }
}

TEST_F(RobotOfTwoComputers, IsNotKeptWherePatternsAreMisreadNowAndThen) {
  see(1000);
  see(1000);
  for (int i = 0; i < 500; ++i) {
    only_they_see(-2000);
    if (i % 10 == 9) see(1000);
    if (i < 20) continue;
    ASSERT_NEAR(x_mm(), -2000, 1) << i;
  }
}

TEST_F(OneRobot, CanBePlacedAtTheFieldsCentre) {
  for (int i = 0; i < 80; ++i) see(3000);
  int missing = 0;
  for (int i = 0; i < 20; ++i) {
    see(0);
    if (!now() || std::abs(now()->place_mm.x()) > 5) ++missing;
  }
  EXPECT_LE(missing, 6);
}

/// Before their difference is learnt, two cameras can see a new robot at positions that imply an impossible
/// speed.
TEST_F(OneRobot, DoesNotFlyOffWhereTwoCamerasDoNotAgree) {
  for (const double apart_mm : {8.0, 15.0, 20.0}) {
    tracker_ = {};
    for (int i = 0; i < 40; ++i) {
      for (int camera = 0; camera < 2; ++camera) {
        Observations seen;
        const double x_mm = 2500 + camera * apart_mm;
        seen.robots.push_back(
            {kName, camera, t_s_, 2e-5, {x_mm, 1000}, 0, Eigen::Matrix2d::Identity() * 0.01, 1e-3});
        tracker_.add(seen);
        t_s_ += 0.0007;
      }
      t_s_ += 0.0119;
      if (i < 3) continue;
      ASSERT_TRUE(now()) << apart_mm << " mm, image " << i;
      EXPECT_NEAR(now()->place_mm.x(), 2510, 80) << apart_mm << " mm, image " << i;
    }
  }
}

TEST_F(OneRobot, IsShownWithASlowCamera) {
  for (int i = 0; i < 10; ++i) {
    see(0);
    t_s_ += 0.11;  // eight images a second
  }
  EXPECT_TRUE(now());
}

TEST_F(OneRobot, StaysItselfWhenAnotherWithItsIdComesNear) {
  for (int i = 0; i < 80; ++i) see(1000);
  for (int i = 0; i < 200; ++i) {
    if (i % 4) see(1000);  // it is hidden now and then
    Observations seen;
    const double other_mm = 2000 - 4.0 * i;
    seen.robots.push_back({kName, 1, t_s_, 2e-5, {other_mm, 0}, 2, Eigen::Matrix2d::Identity() * 0.01, 1e-3});
    tracker_.add(seen);
    if (i % 4 == 0) t_s_ += 0.0125;
    ASSERT_NEAR(now()->place_mm.x(), 1000, 2) << other_mm;
  }
}

TEST(Track, GoesOnWhenTheClockIsSetBack) {
  struct Clock : FieldClock {
    double t_s = 1e9;
    double now_s() const noexcept override { return t_s; }
  } clock;
  Track track;
  TrackedField tracked;
  const auto see = [&](double x_mm) {
    Observations seen;
    seen.robots.push_back({{Team::kBlue, 3},
                           0,
                           clock.t_s - 0.015,
                           2e-5,
                           {x_mm, 0},
                           0,
                           Eigen::Matrix2d::Identity() * 0.01,
                           1e-3});
    seen.balls.push_back({clock.t_s - 0.015, {0, 0, 4000}, {x_mm, 500}, 0.3, 21.5, 1e9});
    track.process({}, clock, BallModel{}, {}, seen, tracked);
    clock.t_s += 0.0125;
  };
  for (int i = 0; i < 80; ++i) see(0);
  clock.t_s -= 3600;
  for (int i = 0; i < 20; ++i) see(2000);
  ASSERT_EQ(tracked.robots.size(), 1U);
  EXPECT_NEAR(tracked.robots[0].place_mm.x(), 2000, 5) << "it is not where it was in the future";
  ASSERT_EQ(tracked.balls.size(), 1U);
  EXPECT_NEAR(tracked.balls[0].place_mm.x(), 2000, 5);
}

/// A filter whose state is not finite never recovers: it is removed.
TEST_F(OneRobot, RecoversFromNonFiniteMeasurements) {
  const double nan = std::nan(""), huge = 1e308;
  const std::vector<std::function<void(RobotObservation&)>> spoils{
      [&](RobotObservation& one) { one.place_mm.x() = nan; },
      [&](RobotObservation& one) { one.orientation_rad = nan; },
      [&](RobotObservation& one) { one.place_cov_mm2 *= nan; },
      [&](RobotObservation& one) { one.place_cov_mm2 *= huge * huge; },
      [&](RobotObservation& one) { one.t_s = nan; },
      [&](RobotObservation& one) { one.t_sigma_s = nan; },
      [&](RobotObservation& one) { one.orientation_sigma_rad = nan; },
  };
  for (std::size_t i = 0; i < spoils.size(); ++i) {
    tracker_ = {};
    for (int image = 0; image < 40; ++image) see(1000);
    Observations seen;
    seen.robots.push_back({kName, 0, t_s_, 2e-5, {1000, 0}, 0, Eigen::Matrix2d::Identity() * 0.01, 1e-3});
    spoils[i](seen.robots[0]);
    Tracker begun_by_it;
    begun_by_it.add(seen);
    tracker_.add(seen);
    EXPECT_EQ(tracker_.repaired(), 1U) << i;
    t_s_ += 0.0125;
    for (int image = 0; image < 4; ++image) see(1000);
    EXPECT_EQ(tracker_.repaired(), 1U) << i << ": no track was left that is not finite";
    EXPECT_EQ(begun_by_it.repaired(), RobotTrack(seen.robots[0]).is_finite() ? 0U : 1U) << i;
    ASSERT_TRUE(now()) << i;
    EXPECT_NEAR(now()->place_mm.x(), 1000, 1) << i;
    EXPECT_TRUE(std::isfinite(now()->turn_rad_s) && std::isfinite(now()->place_sigma_mm)) << i;
  }
}

TEST(Tracker, ABallRecoversFromNonFiniteMeasurements) {
  const double nan = std::nan("");
  for (const bool is_infinite : {false, true}) {
    Tracker tracker;
    double t_s = 1e9;
    const auto see = [&](double sigma_mm) {
      Observations seen;
      seen.balls.push_back({t_s, {0, 0, 4000}, {500, 100}, sigma_mm, 21.5, 1e9});
      tracker.add(seen);
      t_s += 0.0125;
    };
    for (int image = 0; image < 40; ++image) see(0.3);
    ASSERT_TRUE(tracker.ball(t_s));
    see(is_infinite ? std::numeric_limits<double>::infinity() : nan);
    EXPECT_EQ(tracker.repaired(), 1U);
    for (int image = 0; image < 20; ++image) see(0.3);
    ASSERT_TRUE(tracker.ball(t_s));
    EXPECT_NEAR(tracker.ball(t_s)->place_mm.x(), 500, 1);
  }
}

/// A ball and a robot, seen by one camera.
class OneBall : public OneRobot {
 protected:
  void see_ball(std::optional<Eigen::Vector2d> ball_mm, std::optional<double> robot_x_mm = {}) {
    Observations seen;
    if (robot_x_mm) {
      seen.robots.push_back(
          {kName, 0, t_s_, 2e-5, {*robot_x_mm, 0}, 0, Eigen::Matrix2d::Identity() * 0.01, 1e-3});
    }
    if (ball_mm)
      seen.balls.push_back(
          {t_s_, {0, 0, 4000}, *ball_mm, 0.5, 21.5, std::numeric_limits<double>::infinity()});
    tracker_.add(seen);
    t_s_ += 0.0125;
  }
};

TEST_F(OneBall, ThatWasPutElsewhereIsThereWithinATenthOfASecond) {
  for (int i = 0; i < 80; ++i) see_ball(Eigen::Vector2d(500, 100));
  const double put_s = t_s_;
  double told_s = 0;
  for (int i = 0; i < 40 && told_s == 0; ++i) {
    see_ball(Eigen::Vector2d(-2500, 1800));
    if (tracker_.ball(t_s_)->place_mm.x() < -2400) told_s = t_s_;
  }
  EXPECT_GT(told_s, 0);
  EXPECT_LT(told_s - put_s, 0.1);
}

TEST_F(OneBall, StaysWithTheRobotThatHidesIt) {
  for (int i = 0; i < 80; ++i) see_ball(Eigen::Vector2d(1110, 20), 1000);
  double x_mm = 1000;
  for (int i = 0; i < 24; ++i) see_ball({}, x_mm += 0.25 * i);
  const auto ball = tracker_.ball(t_s_);
  ASSERT_TRUE(ball);
  EXPECT_NEAR(ball->place_mm.x(), x_mm + 110, 20) << "the robot has moved to " << x_mm;
  // Something orange far away, for one image, is not the ball.
  see_ball(Eigen::Vector2d(-2000, 500), x_mm);
  EXPECT_NEAR(tracker_.ball(t_s_)->place_mm.x(), x_mm + 110, 40);
}

TEST_F(OneRobot, ThatStartsAndStopsSuddenlyIsFollowed) {
  // A square wave of acceleration, with measurements 1.3 mm off.
  halls::Chance chance(3, "sudden");
  double x_mm = 0, v_mm_s = 0, worst_mm = 0, a_mm_s2 = 3000;
  for (int i = 0; i < 1200; ++i) {
    if (i % 40 == 0) a_mm_s2 = -a_mm_s2;
    for (int part = 0; part < 10; ++part) {
      v_mm_s += a_mm_s2 * 0.00125;
      x_mm += v_mm_s * 0.00125;
    }
    if (i > 400 && now()) worst_mm = std::max(worst_mm, std::abs(now()->place_mm.x() - x_mm));
    Observations seen;
    seen.robots.push_back({kName,
                           0,
                           t_s_,
                           2e-5,
                           {x_mm + 1.3 * chance.normal(), 1.3 * chance.normal()},
                           0,
                           Eigen::Matrix2d::Identity(),
                           1e-3});
    tracker_.add(seen);
    t_s_ += 0.0125;
  }
  EXPECT_LT(worst_mm, 12);
}

TEST_F(OneRobot, IsShownOnceItWasSeenTwice) {
  see(0);
  EXPECT_FALSE(now()) << "it may have been misread";
  see(0);
  EXPECT_TRUE(now());
}

TEST_F(OneRobot, IsNotDraggedAwayByOneWrongSighting) {
  for (int i = 0; i < 80; ++i) see(1000);
  see(2500);
  EXPECT_NEAR(now()->place_mm.x(), 1000, 1);
  EXPECT_NEAR(now()->velocity_mm_s.x(), 0, 1);
}

TEST_F(OneRobot, MovesToItsNewPlaceOnceItStaysThere) {
  for (int i = 0; i < 80; ++i) see(1000);
  for (int i = 0; i < 60; ++i) see(3000);
  ASSERT_TRUE(now());
  EXPECT_NEAR(now()->place_mm.x(), 3000, 1);
}

}  // namespace
}  // namespace sslv::tracker_test
