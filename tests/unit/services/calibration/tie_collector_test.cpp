// SPDX-License-Identifier: Apache-2.0
#include "services/calibration/tie_collector.h"

#include <cmath>

#include <gmock/gmock.h>

namespace sslv::tie_collector_test {
namespace {

constexpr double kPeriodS = 0.0125;

/// A robot as two cameras see it, at 10 mm per px; in the second image it is 400 px further left.
Robot seen_by(std::size_t camera, double x_mm, double y_mm, int id = 3, Team team = Team::kBlue) {
  const double left_px = camera == 0 ? 0 : 400;
  return {team, id, x_mm, y_mm, 0, 140, 300 + x_mm / 10 - left_px, 200 + y_mm / 10, 1};
}

TEST(TieCollector, AStandingRobotIsOneTie) {
  TieCollector collector(2);
  for (int i = 0; i < 10; ++i) {
    const double t_s = 100 + i * kPeriodS;
    const Robot in_a[] = {seen_by(0, 120, 40)}, in_b[] = {seen_by(1, 121, 40), seen_by(1, 2000, 40, 5)};
    collector.add(0, t_s, in_a);
    collector.add(1, t_s + 0.004, in_b);
  }
  const auto ties = collector.ties();
  ASSERT_EQ(ties.size(), 1u);
  EXPECT_EQ(collector.count(), 1u);
  const bool first_is_a = ties[0].camera_a == 0;
  EXPECT_NE(ties[0].camera_a, ties[0].camera_b);
  EXPECT_NEAR((first_is_a ? ties[0].pixel_a : ties[0].pixel_b).x(), 312, 1e-9);
  EXPECT_NEAR((first_is_a ? ties[0].pixel_b : ties[0].pixel_a).x(), -87.9, 1e-9);
  EXPECT_EQ(ties[0].height_mm, 140);
  EXPECT_NEAR(ties[0].sigma_px, 0.3, 1e-9);
}

TEST(TieCollector, AMovingRobotIsInterpolatedToTheOtherCamerasTime) {
  TieCollector collector(2);
  constexpr double kSpeedMmS = 2000;
  for (int i = 0; i < 80; ++i) {
    const double a_s = 100 + i * kPeriodS, b_s = a_s + 0.3 * kPeriodS;
    const Robot in_a[] = {seen_by(0, kSpeedMmS * (a_s - 100), 0)},
                in_b[] = {seen_by(1, kSpeedMmS * (b_s - 100), 0)};
    collector.add(0, a_s, in_a);
    collector.add(1, b_s, in_b);
  }
  const auto ties = collector.ties();
  EXPECT_GE(ties.size(), 7u) << "one for each quarter of a metre";
  EXPECT_LE(ties.size(), 9u);
  for (const OverlapTie& tie : ties) {
    EXPECT_NEAR(std::abs(tie.pixel_a.x() - tie.pixel_b.x()), 400, 1e-6);
    EXPECT_NEAR(tie.sigma_px, std::hypot(0.3, 0.2), 1e-3) << "clocks may differ by 1 ms";
  }
}

TEST(TieCollector, TiesOfSlowCamerasAreLessAccurateWhereARobotMoves) {
  constexpr double kSlowS = 0.1;
  for (const double speed_mm_s : {0.0, 2000.0}) {
    TieCollector collector(2);
    for (int i = 0; i < 10; ++i) {
      const double a_s = 100 + i * kSlowS, b_s = a_s + 0.3 * kSlowS;
      const Robot in_a[] = {seen_by(0, speed_mm_s * (a_s - 100), 0)},
                  in_b[] = {seen_by(1, speed_mm_s * (b_s - 100), 0)};
      collector.add(0, a_s, in_a);
      collector.add(1, b_s, in_b);
    }
    const auto ties = collector.ties();
    ASSERT_FALSE(ties.empty());
    const double accelerated_px = 0.375;
    EXPECT_NEAR(ties[0].sigma_px, speed_mm_s > 0 ? std::hypot(0.3, 0.2, accelerated_px) : 0.3, 1e-6);
  }
}

TEST(TieCollector, DifferentRobotsAreNoTie) {
  TieCollector collector(2);
  for (int i = 0; i < 10; ++i) {
    const double t_s = 100 + i * kPeriodS;
    const Robot in_a[] = {seen_by(0, 0, 0, 1), seen_by(0, 0, 500, 2), seen_by(0, 0, 900, 3)};
    const Robot in_b[] = {seen_by(1, 0, 0, 1, Team::kYellow), seen_by(1, 0, 900, 2)};
    collector.add(0, t_s, in_a);
    collector.add(1, t_s, in_b);
  }
  EXPECT_THAT(collector.ties(), testing::IsEmpty());
}

TEST(TieCollector, IgnoresImagesTooFarApartInTime) {
  TieCollector collector(2);
  for (int i = 0; i < 10; ++i) {
    const Robot in_a[] = {seen_by(0, 0, 0)}, in_b[] = {seen_by(1, 0, 0)};
    collector.add(0, 100 + i * 0.2, in_a);
    collector.add(1, 100.1 + i * 0.2, in_b);
  }
  EXPECT_EQ(collector.count(), 0u);
}

TEST(TieCollector, IgnoresRobotsOfDifferentHeights) {
  TieCollector collector(2);
  for (int i = 0; i < 4; ++i) {
    Robot in_a[] = {seen_by(0, 0, 0)}, in_b[] = {seen_by(1, 0, 0)};
    in_b[0].height_mm = 150;
    collector.add(0, 100 + i * kPeriodS, in_a);
    collector.add(1, 100 + i * kPeriodS, in_b);
  }
  EXPECT_EQ(collector.count(), 0u);
}

TEST(TieCollector, ManyAreThinnedOutEvenly) {
  TieCollector collector(3);
  double t_s = 100;
  for (int x = -20; x < 20; ++x) {
    for (int y = -10; y < 10; ++y) {
      for (int i = 0; i < 2; ++i, t_s += kPeriodS) {
        const Robot in_a[] = {seen_by(0, 250 * x + 100, 250 * y + 100)},
                    in_c[] = {seen_by(2, 250 * x + 100, 250 * y + 100)};
        collector.add(0, t_s, in_a);
        collector.add(2, t_s, in_c);
      }
    }
  }
  EXPECT_EQ(collector.count(), 800u);
  const auto ties = collector.ties();
  EXPECT_EQ(ties.size(), 100u);
  int right = 0;
  for (const OverlapTie& tie : ties) {
    EXPECT_EQ(tie.camera_a + tie.camera_b, 2u);
    right += (tie.camera_a == 0 ? tie.pixel_a : tie.pixel_b).x() > 300 ? 1 : 0;
  }
  EXPECT_NEAR(right, 50, 5);
}

}  // namespace
}  // namespace sslv::tie_collector_test
