// SPDX-License-Identifier: Apache-2.0
#include "vision/confidence.h"

#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace sslv::confidence_test {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity(),
                 kNan = std::numeric_limits<double>::quiet_NaN();

const RobotEvidence kGoodRobot{10, 0.3, 0.95, 0.97, 0};

BallEvidence good_ball() {
  BallEvidence e;
  e.r2 = 0.98;
  e.moved_share = 0.05;
  e.misfit = 0.08;
  e.out_of_round = 0.4;
  e.radius_off = 0.3;
  e.radius_sigma = 0.02;
  e.color_off = 0.2;
  e.contrast = 0.8;
  return e;
}

/// Expects that confidence never falls (if not `rises`: never rises) while one number of the evidence grows.
template <class Evidence>
void expect_monotone(const Evidence& good, double Evidence::*field, const std::vector<double>& values,
                     bool rises, const std::string& what) {
  double last = rises ? -1 : 2;
  for (const double value : values) {
    Evidence e = good;
    e.*field = value;
    const double now = confidence_of(e);
    EXPECT_GE(now, 0) << what;
    EXPECT_LE(now, 1) << what;
    if (rises) {
      EXPECT_GE(now, last) << what << " " << value;
    } else {
      EXPECT_LE(now, last) << what << " " << value;
    }
    last = now;
  }
}

TEST(Confidence, OfARobotGrowsWithItsEvidence) {
  EXPECT_GT(confidence_of(kGoodRobot), 0.95);
  expect_monotone(kGoodRobot, &RobotEvidence::min_sure, {0, 0.01, 0.1, 1, 10, 1000}, true, "min_sure");
  expect_monotone(kGoodRobot, &RobotEvidence::rms_mm, {0, 0.1, 0.5, 1, 3, 10, 100}, false, "rms_mm");
  expect_monotone(kGoodRobot, &RobotEvidence::min_r2, {0, 0.2, 0.5, 0.8, 1}, true, "min_r2");
  double last = 2;
  for (int unproven = 0; unproven <= 4; ++unproven) {
    RobotEvidence e = kGoodRobot;
    e.unproven = unproven;
    EXPECT_LE(confidence_of(e), last) << unproven;
    last = confidence_of(e);
  }
}

TEST(Confidence, OfABallGrowsWithItsEvidence) {
  EXPECT_GT(confidence_of(good_ball()), 0.95);
  expect_monotone(good_ball(), &BallEvidence::r2, {-1, 0, 0.2, 0.5, 0.8, 0.95, 0.999, 1, 1.1}, true, "r2");
  expect_monotone(good_ball(), &BallEvidence::moved_share, {0, 0.1, 0.3, 1, 5}, false, "moved_share");
  expect_monotone(good_ball(), &BallEvidence::clear_share, {0, 0.3, 0.7, 1}, true, "clear_share");
  expect_monotone(good_ball(), &BallEvidence::tape_gain, {-kInf, -1, -0.1, 0, 0.1, 0.5, 3, kInf}, false,
                  "tape_gain");
  expect_monotone(good_ball(), &BallEvidence::misfit, {-1, 0, 0.05, 0.1, 0.3, 1, 5}, false, "misfit");
  expect_monotone(good_ball(), &BallEvidence::out_of_round, {0, 0.5, 1, 3, 10, 100}, false, "out_of_round");
  expect_monotone(good_ball(), &BallEvidence::contrast, {0, 0.1, 0.3, 0.7, 1, 2}, true, "contrast");
  expect_monotone(good_ball(), &BallEvidence::radius_off, {0, 0.5, 1, 3, 10, 100}, false, "radius_off");
  expect_monotone(good_ball(), &BallEvidence::radius_sigma, {0, 0.01, 0.05, 0.3, 2}, false, "radius_sigma");
  expect_monotone(good_ball(), &BallEvidence::area_ratio, {0, 0.1, 0.5, 1}, true, "area_ratio up to one");
  expect_monotone(good_ball(), &BallEvidence::area_ratio, {1, 1.2, 2, 5, 100}, false, "area_ratio from one");
  expect_monotone(good_ball(), &BallEvidence::max_alike, {-1, 0, 0.3, 0.7, 1, 2}, false, "max_alike");
  expect_monotone(good_ball(), &BallEvidence::outside_mm, {-1000, 0, 50, 150, 1000}, false, "outside_mm");
  expect_monotone(good_ball(), &BallEvidence::color_off, {0, 0.05, 0.1, 0.3, 1, 2, 5, 100}, false,
                  "color_off");
  BallEvidence yellow = good_ball();
  yellow.is_orange = false;
  EXPECT_LT(confidence_of(yellow), confidence_of(good_ball()));
}

TEST(Confidence, IsANumberWhateverTheEvidence) {
  const std::vector<double> odd{kNan,   kInf, -kInf, 1e300,
                                -1e300, 0,    -1,    std::numeric_limits<double>::denorm_min()};
  for (const double value : odd) {
    for (const auto field : {&RobotEvidence::min_sure, &RobotEvidence::rms_mm, &RobotEvidence::min_r2,
                             &RobotEvidence::mean_r2}) {
      RobotEvidence e = kGoodRobot;
      e.*field = value;
      const double confidence = confidence_of(e);
      EXPECT_TRUE(confidence >= 0 && confidence <= 1) << confidence << " of " << value;
    }
    for (const auto field :
         {&BallEvidence::r2, &BallEvidence::moved_share, &BallEvidence::clear_share, &BallEvidence::misfit,
          &BallEvidence::out_of_round, &BallEvidence::radius_off, &BallEvidence::radius_sigma,
          &BallEvidence::area_ratio, &BallEvidence::visible_share, &BallEvidence::color_off,
          &BallEvidence::contrast, &BallEvidence::max_alike, &BallEvidence::outside_mm}) {
      BallEvidence e = good_ball();
      e.*field = value;
      const double confidence = confidence_of(e);
      EXPECT_TRUE(confidence >= 0 && confidence <= 1) << confidence << " of " << value;
    }
  }
  // Without any evidence, confidence is not full.
  EXPECT_LT(confidence_of(RobotEvidence{}), 1);
  EXPECT_LT(confidence_of(BallEvidence{}), 0.95);
}

TEST(Confidence, IsZeroForNonFiniteEvidence) {
  RobotEvidence robot = kGoodRobot;
  robot.rms_mm = kNan;
  EXPECT_EQ(confidence_of(robot), 0);
  BallEvidence ball = good_ball();
  ball.misfit = kNan;
  EXPECT_EQ(confidence_of(ball), 0);
}

}  // namespace
}  // namespace sslv::confidence_test
