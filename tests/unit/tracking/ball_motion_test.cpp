// SPDX-License-Identifier: Apache-2.0
#include "tracking/ball_motion.h"

#include "halls/chance.h"
#include "tracking/ball_flight.h"
#include "tracking/kick_fit.h"

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace sslv::ball_motion_test {
namespace {

TEST(BallMotion, SlidesThenRollsThenLies) {
  const BallModel model{};
  const double speed = 3500;
  const double slides_s = speed * (1 - model.rolls_from_share) / model.slides_mm_s2;
  EXPECT_NEAR(flat_way(speed, slides_s, model).speed_mm_s, speed * model.rolls_from_share, 1e-6);
  EXPECT_NEAR(flat_way(speed, slides_s + 1, model).speed_mm_s,
              speed * model.rolls_from_share - model.rolls_mm_s2, 1e-6);
  const FlatWay end = flat_way(speed, 100, model);
  EXPECT_NEAR(end.speed_mm_s, 0, 1e-9);
  EXPECT_NEAR(end.way_mm, flat_way(speed, 200, model).way_mm, 1e-6);
  // The distance is the integral of the speed.
  double way = 0;
  for (int i = 0; i < 2000; ++i) way += flat_way(speed, (i + 0.5) * 1e-3, model).speed_mm_s * 1e-3;
  EXPECT_NEAR(way, flat_way(speed, 2, model).way_mm, 0.1);
}

TEST(BallMotion, AChipLandsWhereItSaysAndHopsOn) {
  const BallModel model{};
  const BallShot shot{10, {100, 200}, {3000, 1000, 3000}};
  const double lands_s = 10 + 2 * 3000 / 9810.0;
  const BallState landing = shot.at(lands_s - 1e-9, model);
  EXPECT_NEAR(landing.place_mm.z(), model.radius_mm, 1e-3);
  EXPECT_NEAR((landing.place_mm.head<2>() - shot.landing_mm()).norm(), 0, 1e-3);
  const BallState after = shot.at(lands_s + 1e-9, model);
  EXPECT_NEAR(after.velocity_mm_s.x(), model.first_hop_xy * 3000, 1e-3);
  EXPECT_NEAR(after.velocity_mm_s.z(), model.hops_z * 3000, 1e-3);
  EXPECT_NEAR(shot.at(lands_s + 5, model).velocity_mm_s.z(), 0, 1e-9);
}

TEST(BallMotion, OneThatIsTurnedInTheAirFallsAsBefore) {
  const BallModel model{};
  const BallShot shot{10, {100, 200}, {3000, 1000, 3000}};
  const BallState then = shot.at(10.4, model);
  const BallShot turned{10.4,
                        then.place_mm.head<2>(),
                        {-500, 700, then.velocity_mm_s.z()},
                        then.place_mm.z() - model.radius_mm};
  for (const double t_s : {10.4, 10.5, 10.6, 10.8}) {
    EXPECT_NEAR(turned.at(t_s, model).place_mm.z(), shot.at(t_s, model).place_mm.z(), 1e-6) << t_s;
    EXPECT_NEAR(turned.at(t_s, model).velocity_mm_s.z(), shot.at(t_s, model).velocity_mm_s.z(), 1e-6) << t_s;
  }
  EXPECT_NEAR((turned.at(10 + 6000 / 9810.0, model).place_mm.head<2>() - turned.landing_mm()).norm(), 0,
              1e-3);
}

class KickFit : public testing::Test {
 protected:
  /// The shot as two cameras see it alternately, with noise.
  std::vector<ShotPoint> seen(const BallShot& shot, int count) {
    std::vector<ShotPoint> out;
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector3d camera(i % 2 ? 2000 : -2000, 500, 5000);
      const double t_s = shot.t_s + 0.004 + i * 0.0067;
      const BallState ball = shot.at(t_s, model_);
      const double farther = (camera.z() - model_.radius_mm) / (camera.z() - ball.place_mm.z());
      Eigen::Vector2d place = camera.head<2>() + (ball.place_mm.head<2>() - camera.head<2>()) * farther;
      place.x() += 0.3 * chance_.normal();
      place.y() += 0.3 * chance_.normal();
      out.push_back({t_s, camera, place, 0.3, ball.place_mm.z() + 70 * chance_.normal(), 70});
    }
    return out;
  }

  const BallModel model_{};
  halls::Chance chance_{5, "kick"};
};

TEST_F(KickFit, FindsAShotAlongTheFloor) {
  const BallShot shot{100, {500, -300}, {4000, 1500, 0}};
  ShotFit guess;
  guess.shot = {100, {505, -297}, {3800, 1700, 0}};
  guess.slides_mm_s2 = 3500;
  const auto points = seen(shot, 16);
  const ShotFit flat = fit_flat(guess, points, model_, {});
  EXPECT_NEAR((flat.shot.velocity_mm_s - shot.velocity_mm_s).norm(), 0, 25);
  EXPECT_NEAR((flat.shot.place_mm - shot.place_mm).norm(), 0, 1.5);
  ShotFit as_chip = guess;
  as_chip.shot.velocity_mm_s.z() = 2000;
  EXPECT_GT(fit_chip(as_chip, points, model_, {}, 8).chi2, flat.chi2 + 20);
}

TEST_F(KickFit, FindsAFlyingBallWithoutPriorState) {
  // The ball has bounced off a wall and is falling.
  const BallShot shot{100, {500, -300}, {-1500, 900, 500}, 400};
  const auto points = seen(shot, 16);
  const auto flight = find_flight(points, model_);
  ASSERT_TRUE(flight);
  const BallState truth = shot.at(flight->t_s, model_);
  EXPECT_NEAR((flight->state.head<3>() - truth.place_mm).norm(), 0, 60);
  // The flight continues after its next hop.
  BallFlight later = *flight;
  for (const ShotPoint& point : seen(shot, 80)) {
    if (point.t_s > later.t_s && !later.is_over) later.correct(point, model_);
  }
  EXPECT_TRUE(later.has_hopped);
  EXPECT_NEAR((later.state.head<3>() - shot.at(later.t_s, model_).place_mm).norm(), 0, 15);
}

TEST_F(KickFit, FindsNoBallInTheAirThatSlidesOrRolls) {
  for (const double speed : {300.0, 2000.0, 5000.0}) {
    for (const std::size_t count : {5U, 12U, 30U}) {
      const auto points = seen({100, {500, -300}, {speed, 0.4 * speed, 0}}, 30);
      EXPECT_FALSE(find_flight(std::span(points).first(count), model_)) << speed << " " << count;
    }
  }
}

/// Floors differ in how the ball bounces.
TEST_F(KickFit, AFlightGoesOnAfterABounceThatWasNotForeseen) {
  const BallShot shot{100, {500, -300}, {3000, -600, 2800}};
  const auto points = seen(shot, 60);
  BallFlight flight;
  for (const ShotPoint& point : points) {
    if (point.t_s > shot.t_s + 0.2 && flight.t_s == 0) {
      const BallState then = shot.at(point.t_s, model_);
      flight.t_s = point.t_s;
      flight.state << then.place_mm, then.velocity_mm_s;
      flight.cov.diagonal() << 400, 400, 400, 1e4, 1e4, 1e4;
    }
  }
  BallModel steel = model_;  // floor of another kind
  steel.first_hop_xy = 0.45;
  steel.hops_z = 0.55;
  const double lands_s = shot.t_s + shot.lands_after_s();
  for (double t_s = flight.t_s; t_s < lands_s + 0.25; t_s += 0.0067) {
    const BallState ball = shot.at(t_s, steel);
    const Eigen::Vector3d camera(-2000, 500, 5000);
    const double farther = (camera.z() - model_.radius_mm) / (camera.z() - ball.place_mm.z());
    const Eigen::Vector2d place = camera.head<2>() + (ball.place_mm.head<2>() - camera.head<2>()) * farther;
    flight.correct({t_s, camera, place, 0.3, 0, std::numeric_limits<double>::infinity()}, model_);
    EXPECT_FALSE(flight.is_over) << t_s - lands_s;
    if (t_s < lands_s + 0.1) continue;
    EXPECT_LT((flight.state.head<3>() - ball.place_mm).norm(), 60) << t_s - lands_s;
  }
}

TEST_F(KickFit, FindsNoFlightThatNoRobotCanStart) {
  for (const Eigen::Vector3d& velocity_mm_s :
       {Eigen::Vector3d(400, 200, 5500), Eigen::Vector3d(6000, 2000, 5000)}) {
    const auto points = seen({100, {500, -300}, velocity_mm_s, 100}, 30);
    EXPECT_FALSE(find_flight(points, model_)) << velocity_mm_s.transpose();
  }
}

TEST_F(KickFit, FindsAChipByWhereCamerasSeeIt) {
  const BallShot shot{100, {500, -300}, {2500, 900, 2700}};
  ShotFit guess;
  guess.shot = {100.002, {503, -298}, {2300, 1000, 2000}};
  guess.slides_mm_s2 = 3500;
  const auto points = seen(shot, 24);
  const ShotFit chip = fit_chip(guess, points, model_, {}, 12);
  EXPECT_NEAR((chip.shot.landing_mm() - shot.landing_mm()).norm(), 0, 40);
  EXPECT_NEAR(chip.shot.t_s, 100, 0.002);
  ShotFit as_flat = guess;
  as_flat.shot.velocity_mm_s.z() = 0;
  EXPECT_GT(fit_flat(as_flat, points, model_, {}).chi2, chip.chi2 + 20);
}

TEST(BallShot, SaysWhenItLiesStill) {
  const BallModel model;
  const BallShot flat{.t_s = 10, .place_mm = {0, 0}, .velocity_mm_s = {3000, 0, 0}};
  const double slides_s = 3000 * (1 - model.rolls_from_share) / model.slides_mm_s2;
  const double rolls_s = 3000 * model.rolls_from_share / model.rolls_mm_s2;
  EXPECT_NEAR(flat.stops_s(model), 10 + slides_s + rolls_s, 0.01);
  const BallShot chip{.t_s = 10, .place_mm = {0, 0}, .velocity_mm_s = {2000, 0, 2500}};
  const double stops_s = chip.stops_s(model);
  EXPECT_LT(chip.at(stops_s, model).velocity_mm_s.norm(), 2);
  EXPECT_GT(chip.at(stops_s - 0.1, model).velocity_mm_s.norm(), 20);
}

}  // namespace
}  // namespace sslv::ball_motion_test
