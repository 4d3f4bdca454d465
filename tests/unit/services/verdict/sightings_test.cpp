// SPDX-License-Identifier: Apache-2.0
#include "services/verdict/sightings.h"

#include <gmock/gmock.h>

namespace sslv::sightings_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr double kPeriod_s = 0.1;

Robot robot(Team team, int id, double x_mm, double y_mm) {
  return {team, id, x_mm, y_mm, 0, 140, 100, 100, 1};
}

/// Cameras 0 and 1, with detections that a test defines.
class SightingsTest : public ::testing::Test {
 protected:
  /// Adds each camera's detections, every kPeriod_s, for this long.
  void look_for(double duration_s, const std::vector<Robot>& in_0, const std::vector<Robot>& in_1) {
    const double end_s = t_s_ + duration_s;
    for (; t_s_ < end_s; t_s_ += kPeriod_s) {
      sightings_.add(0, t_s_, 1e6 + t_s_, in_0, {});
      sightings_.add(1, t_s_, 1e6 + t_s_ + 0.004, in_1, {});
    }
  }
  FieldSeen now() const { return sightings_.now(t_s_); }

  Sightings sightings_;
  double t_s_ = 10;
};

TEST_F(SightingsTest, CountsARobotOnceWhichTwoCamerasSee) {
  look_for(1, {robot(Team::kYellow, 3, 0, 0), robot(Team::kBlue, 1, 500, 0)},
           {robot(Team::kYellow, 3, 4, 0)});
  EXPECT_THAT(now().ids[0], ElementsAre(3));
  EXPECT_THAT(now().ids[1], ElementsAre(1));
  EXPECT_THAT(now().lost, IsEmpty());
  EXPECT_THAT(now().doubles, IsEmpty());
}

TEST_F(SightingsTest, ASteadyRobotIsMissedForAMinute) {
  look_for(6, {robot(Team::kYellow, 3, 70, -20)}, {});
  look_for(2, {}, {});
  ASSERT_EQ(now().lost.size(), 1U);
  EXPECT_EQ(now().lost[0].id, 3);
  EXPECT_NEAR(now().lost[0].gone_s, 2.2, 0.3);
  EXPECT_EQ(now().lost[0].place_mm, Eigen::Vector2d(70, -20));
  look_for(60, {}, {});
  EXPECT_THAT(now().lost, IsEmpty());
}

TEST_F(SightingsTest, RobotsThatWaitBehindTheirOwnGoalAreNotOnTheField) {
  const FieldSize field = field_preset("division-a", "");  // wall at 6600 mm; the area is 300 mm deep
  const std::vector<Robot> robots{robot(Team::kBlue, 1, 6400, 0), robot(Team::kBlue, 2, 6380, 0),
                                  robot(Team::kBlue, 3, -6400, 0), robot(Team::kYellow, 4, -6400, 2000),
                                  robot(Team::kYellow, 5, 6400, 2000)};
  look_for(6, robots, {});
  const auto waiting = [&](std::optional<bool> blue_at_positive_x) {
    return sightings_.now(t_s_, {}, SubstitutionAreas{field, blue_at_positive_x}).waiting;
  };
  EXPECT_THAT(waiting(true), ElementsAre(ElementsAre(4), ElementsAre(1)));
  EXPECT_THAT(waiting(false), ElementsAre(ElementsAre(5), ElementsAre(3)));
  EXPECT_THAT(waiting({}), ElementsAre(ElementsAre(4, 5), ElementsAre(1, 3))) << "wherever their goals are";
  const FieldSeen seen = sightings_.now(t_s_, {}, SubstitutionAreas{field, true});
  EXPECT_THAT(seen.ids, ElementsAre(ElementsAre(4, 5), ElementsAre(1, 2, 3))) << "they are seen";
  EXPECT_EQ(seen.on_field(Team::kYellow), 1U);
  EXPECT_EQ(seen.on_field(Team::kBlue), 2U);

  look_for(2, {}, {});
  std::vector<int> lost;
  for (const LostRobot& one : sightings_.now(t_s_, {}, SubstitutionAreas{field, true}).lost)
    lost.push_back(one.id);
  EXPECT_THAT(lost, testing::UnorderedElementsAre(2, 3, 5)) << "their teams took the others";
  EXPECT_EQ(now().lost.size(), 5U);
}

std::vector<Robot> team_of(Team team, std::initializer_list<int> ids) {
  std::vector<Robot> robots;
  for (const int id : ids) robots.push_back(robot(team, id, 300.0 * id, 0));
  return robots;
}

TEST_F(SightingsTest, CountsRobotsThatVanishedTogether) {
  look_for(6, team_of(Team::kYellow, {1, 2, 3, 4, 5}), {});
  look_for(10, team_of(Team::kYellow, {2, 3, 4, 5}), {});  // they disappear one by one, 10 s apart
  look_for(10, team_of(Team::kYellow, {3, 4, 5}), {});
  look_for(10, team_of(Team::kYellow, {4, 5}), {});
  ASSERT_EQ(now().lost.size(), 3U);
  for (const LostRobot& lost : now().lost) EXPECT_EQ(lost.at_once, 1U) << lost.id;
  look_for(3, team_of(Team::kYellow, {4}), {});
  look_for(2, {}, {});
  for (const LostRobot& lost : now().lost) EXPECT_EQ(lost.at_once, lost.id >= 4 ? 2U : 1U) << lost.id;
}

TEST_F(SightingsTest, DuringAMatchManyAreMissedUntilAsManyReturn) {
  const double match_since_s = t_s_;
  const auto missed = [&] { return sightings_.now(t_s_, match_since_s).lost.size(); };
  look_for(6, team_of(Team::kYellow, {1, 2, 3, 4}), team_of(Team::kBlue, {7}));
  look_for(90, {}, {});
  EXPECT_EQ(missed(), 4U) << "the other team's one may have been taken off";
  EXPECT_EQ(now().lost.size(), 0U) << "before a match teams go for a break";
  EXPECT_EQ(sightings_.now(t_s_, t_s_ - 30).lost.size(), 0U) << "or between two halves";
  look_for(2, team_of(Team::kYellow, {8}), {});
  EXPECT_EQ(missed(), 4U) << "three of four are still missing";
  look_for(2, team_of(Team::kYellow, {8, 9}), {});
  EXPECT_EQ(missed(), 0U) << "two of four: as after a change of robots";
  look_for(7, team_of(Team::kYellow, {8, 9, 10, 11}), {});
  EXPECT_EQ(missed(), 0U);
}

TEST_F(SightingsTest, DuringAMatchReturningRobotsCountOnlyForThemselves) {
  const double match_since_s = t_s_;
  const auto missed = [&] { return sightings_.now(t_s_, match_since_s).lost.size(); };
  look_for(6, team_of(Team::kYellow, {1, 2, 3, 4, 5, 6}), {});
  look_for(90, {}, {});
  EXPECT_EQ(missed(), 6U);
  look_for(7, team_of(Team::kYellow, {1, 2}), {});
  EXPECT_EQ(missed(), 4U);
  look_for(7, team_of(Team::kYellow, {1, 2, 3, 4}), {});
  EXPECT_EQ(missed(), 0U) << "two may be at their team";
}

TEST_F(SightingsTest, DuringAMatchAGlimpseIsNoReturn) {
  const double match_since_s = t_s_;
  const auto missed = [&] { return sightings_.now(t_s_, match_since_s).lost.size(); };
  look_for(6, team_of(Team::kYellow, {1, 2, 3, 4, 5, 6}), {});
  look_for(70, {}, {});
  for (int id = 1; id <= 6; ++id) {
    look_for(0.3, team_of(Team::kYellow, {id}), {});
    look_for(2, {}, {});
  }
  EXPECT_EQ(missed(), 6U);
  look_for(70, {}, {});
  EXPECT_EQ(missed(), 6U);
}

TEST_F(SightingsTest, DuringAMatchRemovedRobotsAreSoonNotExpected) {
  const double match_since_s = t_s_;
  const auto lost = [&] { return sightings_.now(t_s_, match_since_s).lost; };
  look_for(6, team_of(Team::kYellow, {1, 2, 3, 4}), {});
  sightings_.robots_are_handled(true);
  look_for(1, team_of(Team::kYellow, {1, 2, 3, 4}), {});
  look_for(5, {}, {});
  ASSERT_EQ(lost().size(), 4U);
  EXPECT_TRUE(lost()[0].was_handled);
  look_for(60, {}, {});
  EXPECT_THAT(lost(), IsEmpty());
}

TEST_F(SightingsTest, RobotsLostInPlayAreMissedThroughAHalt) {
  const double match_since_s = t_s_;
  look_for(6, team_of(Team::kYellow, {1, 2, 3, 4}), {});
  look_for(10, {}, {});
  sightings_.robots_are_handled(true);
  look_for(90, {}, {});
  EXPECT_EQ(sightings_.now(t_s_, match_since_s).lost.size(), 4U);
}

TEST_F(SightingsTest, KnowsForHowLongATeamIsGone) {
  look_for(6, team_of(Team::kYellow, {1, 2}), {});
  look_for(4, team_of(Team::kYellow, {2}), {});
  EXPECT_LT(now().team_gone_s[0].value_or(9), 0.2);
  EXPECT_FALSE(now().team_gone_s[1]) << "never seen";
  look_for(4, {}, {});
  EXPECT_NEAR(now().team_gone_s[0].value_or(0), 4, 0.2);
}

TEST_F(SightingsTest, DuringAMatchASingleLostRobotIsMissedForAMinute) {
  const double match_since_s = t_s_;
  look_for(6, team_of(Team::kYellow, {1, 2, 3, 4}), {});
  look_for(50, team_of(Team::kYellow, {3, 4}), {});
  EXPECT_EQ(sightings_.now(t_s_, match_since_s).lost.size(), 2U);
  look_for(15, team_of(Team::kYellow, {3, 4}), {});
  EXPECT_THAT(sightings_.now(t_s_, match_since_s).lost, IsEmpty());
}

TEST_F(SightingsTest, DoesNotMissRobotsSeenOnlyBriefly) {
  look_for(2, {robot(Team::kBlue, 7, 0, 0)}, {});
  look_for(3, {}, {});
  EXPECT_THAT(now().lost, IsEmpty());
}

TEST_F(SightingsTest, ShortGapsAreNoLoss) {
  for (int i = 0; i < 10; ++i) {
    look_for(0.8, {robot(Team::kBlue, 7, 0, 0)}, {});
    look_for(0.6, {}, {});
    EXPECT_THAT(now().lost, IsEmpty());
  }
}

TEST_F(SightingsTest, NamesOneIdInTwoPlaces) {
  look_for(2, {robot(Team::kYellow, 5, -2000, 0)}, {robot(Team::kYellow, 5, 2000, 0)});
  ASSERT_EQ(now().doubles.size(), 1U);
  EXPECT_EQ(now().doubles[0].id, 5);
  look_for(4, {robot(Team::kYellow, 5, -2000, 0)}, {});
  EXPECT_THAT(now().doubles, IsEmpty());
}

TEST_F(SightingsTest, NamesOneIdTwiceInOneImage) {
  look_for(2, {robot(Team::kYellow, 5, -2000, 0), robot(Team::kYellow, 5, 100, 0)}, {});
  ASSERT_EQ(now().doubles.size(), 1U);
  EXPECT_EQ(now().doubles[0].cameras, (std::array{0, 0}));
}

TEST_F(SightingsTest, NamesASecondRobotThatIsNotPublished) {
  const Robot first[] = {robot(Team::kYellow, 5, -2000, 0)}, second[] = {robot(Team::kYellow, 5, 100, 0)};
  for (int i = 0; i < 5; ++i, t_s_ += kPeriod_s) sightings_.add(0, t_s_, 1e6 + t_s_, first, {}, second);
  ASSERT_EQ(now().doubles.size(), 1U);
  EXPECT_EQ(now().doubles[0].places_mm[0], Eigen::Vector2d(-2000, 0));
  EXPECT_EQ(now().doubles[0].places_mm[1], Eigen::Vector2d(100, 0));
  look_for(4, {first[0]}, {});
  EXPECT_THAT(now().doubles, IsEmpty());
}

TEST_F(SightingsTest, ASingleWrongIdIsNoSecondRobot) {
  look_for(2, {robot(Team::kYellow, 5, -2000, 0)}, {});
  look_for(kPeriod_s, {robot(Team::kYellow, 5, -2000, 0)}, {robot(Team::kYellow, 5, 2000, 0)});
  look_for(1, {robot(Team::kYellow, 5, -2000, 0)}, {});
  EXPECT_THAT(now().doubles, IsEmpty());
}

TEST_F(SightingsTest, ASteadyBallIsMissedForAMinute) {
  const std::vector<Ball> balls(1);
  const auto look_for_ball = [&](double duration_s, std::span<const Ball> seen) {
    for (const double end_s = t_s_ + duration_s; t_s_ < end_s; t_s_ += kPeriod_s)
      sightings_.add(0, t_s_, 1e6 + t_s_, {}, seen);
  };
  look_for_ball(3, balls);
  look_for_ball(3, {});
  EXPECT_FALSE(now().ball_gone_s) << "seen for a moment only";
  look_for_ball(6, balls);
  EXPECT_TRUE(now().ball);
  look_for_ball(4, {});
  EXPECT_FALSE(now().ball);
  EXPECT_NEAR(now().ball_gone_s.value_or(0), 4, 0.5);
  look_for_ball(60, {});
  EXPECT_FALSE(now().ball_gone_s);
}

TEST_F(SightingsTest, SaysHowFarApartCamerasSeeTheSameRobots) {
  look_for(5, {robot(Team::kYellow, 5, 0, 0), robot(Team::kYellow, 6, 0, 500)},
           {robot(Team::kYellow, 5, 40, 0), robot(Team::kYellow, 6, 0, 544)});
  ASSERT_EQ(now().overlaps.size(), 1U);
  EXPECT_NEAR(now().overlaps[0].apart_mm, 42, 3);
}

TEST_F(SightingsTest, ADrivingRobotIsAtTheSamePlaceInBothCameras) {
  constexpr double kSpeedMm_s = 1400;
  for (int i = 0; i < 50; ++i, t_s_ += kPeriod_s) {
    const double x_mm = kSpeedMm_s * t_s_;
    const Robot in_0[] = {robot(Team::kBlue, 1, x_mm, 0)};
    const Robot in_1[] = {robot(Team::kBlue, 1, x_mm + kSpeedMm_s * 0.016, 0)};
    sightings_.add(0, t_s_, 1e6 + t_s_, in_0, {});
    sightings_.add(1, t_s_, 1e6 + t_s_ + 0.016, in_1, {});
  }
  ASSERT_EQ(now().overlaps.size(), 1U);
  EXPECT_LT(now().overlaps[0].apart_mm, 3);
}

TEST_F(SightingsTest, ForgetsOneCamerasSightings) {
  look_for(6, {robot(Team::kYellow, 5, 0, 0)}, {robot(Team::kYellow, 5, 100, 0)});
  sightings_.forget(1);
  EXPECT_THAT(now().overlaps, IsEmpty());
  EXPECT_THAT(now().ids[0], ElementsAre(5));
  look_for(2, {}, {});
  EXPECT_EQ(now().lost.size(), 1U) << "its camera, with another exposure, should still see it";
}

TEST_F(SightingsTest, ExpectsNothingOfACameraThatIsGone) {
  const Ball balls[1] = {};
  for (int i = 0; i < 60; ++i, t_s_ += kPeriod_s) {
    sightings_.add(0, t_s_, 1e6 + t_s_, team_of(Team::kYellow, {3}), {});
    sightings_.add(1, t_s_, 1e6 + t_s_, team_of(Team::kBlue, {1, 2}), balls);
  }
  sightings_.expect_nothing_of(1);
  look_for(3, {}, {});
  EXPECT_FALSE(now().ball_gone_s);
  ASSERT_EQ(now().lost.size(), 1U) << "the other camera's";
  EXPECT_EQ(now().lost[0].id, 3);
}

}  // namespace
}  // namespace sslv::sightings_test
