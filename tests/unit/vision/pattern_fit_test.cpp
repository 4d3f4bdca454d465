// SPDX-License-Identifier: Apache-2.0
#include "vision/pattern_fit.h"

#include "support/drawn_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

namespace sslv::pattern_fit_test {
namespace {

constexpr double kPi = std::numbers::pi, kDegree = kPi / 180, kHeightMm = 140;
constexpr int kPasses = 5;
const std::array kColorFormats{PixelFormat::kUyvy, PixelFormat::kRgb24, PixelFormat::kBayerRg8};

double turn_between(double a_rad, double b_rad) {
  return std::abs(std::remainder(a_rad - b_rad, 2 * kPi));
}

class PatternFitIn : public ::testing::TestWithParam<PixelFormat> {
 protected:
  static constexpr int kRobots = 12;
  void add_robots(int covered_dot = -1) {
    for (int i = 0; i < kRobots; ++i) {
      drawn_.add_robot(i % 2 == 0 ? Team::kBlue : Team::kYellow, i, 300 + 650.3 * (i / 4),
                       -1500.7 + 1000.9 * (i % 4), 0.53 * i, covered_dot);
    }
  }
  PatternFitter::Frame frame() {
    view_ = drawn_.image().view();
    return {view_, *drawn_.scene().camera, league_patterns(), drawn_.lut(), 0.55};
  }
  DrawnScene drawn_{plain_options(GetParam(), 3)};
  PatternFitter fitter_;
  ImageView view_;
};

TEST_P(PatternFitIn, FindsThePoseFromAStartFiveMillimetresOff) {
  add_robots();
  const auto frame = this->frame();
  for (const SimulatedRobot& robot : drawn_.things().robots) {
    const PatternFit fit = fitter_.fit(frame, {robot.x_mm + 3, robot.y_mm - 4, robot.orientation_rad + 0.06},
                                       kHeightMm, kPasses);
    ASSERT_EQ(fit.seen, 5) << robot.id;
    EXPECT_LT(std::hypot(fit.pose.x_mm - robot.x_mm, fit.pose.y_mm - robot.y_mm), 0.5);
    EXPECT_LT(turn_between(fit.pose.angle_rad, robot.orientation_rad), 0.5 * kDegree);
    EXPECT_LT(fit.rms_mm, 1);
    EXPECT_GT(fit.min_r2, 0.8);
    EXPECT_GE(fit.mean_r2, fit.min_r2);
    const auto pixel = drawn_.scene().camera->project({robot.x_mm, robot.y_mm, kHeightMm});
    EXPECT_NEAR(fit.pixel_x, pixel->x(), 0.1);
    EXPECT_NEAR(fit.pixel_y, pixel->y(), 0.1);
  }
}

TEST_P(PatternFitIn, NamesTheColoursOfAllDots) {
  add_robots();
  const auto frame = this->frame();
  for (const SimulatedRobot& robot : drawn_.things().robots) {
    const PatternFit fit =
        fitter_.fit(frame, {robot.x_mm, robot.y_mm, robot.orientation_rad}, kHeightMm, kPasses);
    const auto& center = fit.dots[PatternFit::kCenter];
    EXPECT_EQ(center.color, robot.team == Team::kBlue ? label::kBlue : label::kYellow);
    EXPECT_GT(center.margin, 0.3);
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_EQ(fit.dots[i].color, league_patterns().codes[static_cast<std::size_t>(robot.id)].colors[i]);
      EXPECT_GT(fit.dots[i].margin, 0.3);
    }
  }
}

TEST_P(PatternFitIn, TheSameResultFromAnyStart) {
  // The estimate depends on the image only, not on the start.
  add_robots();
  const auto frame = this->frame();
  const SimulatedRobot& robot = drawn_.things().robots[5];
  const auto from = [&](double dx, double dy, double turn) {
    return fitter_.fit(frame, {robot.x_mm + dx, robot.y_mm + dy, robot.orientation_rad + turn}, kHeightMm, 10)
        .pose;
  };
  const PatternPose here = from(0, 0, 0);
  for (int i = 0; i < 8; ++i) {
    const PatternPose there = from(5 * std::cos(i), 5 * std::sin(i), i % 2 == 0 ? 0.05 : -0.05);
    EXPECT_LT(std::hypot(there.x_mm - here.x_mm, there.y_mm - here.y_mm), 0.1) << i;
    EXPECT_LT(turn_between(there.angle_rad, here.angle_rad), 0.1 * kDegree) << i;
  }
}

TEST_P(PatternFitIn, ACoveredDotIsNotSeenAndDoesNotMoveThePose) {
  int ghosts = 0;
  for (int dot = 0; dot < 4; ++dot) {
    drawn_.clear();
    add_robots(dot);
    const auto frame = this->frame();
    for (const SimulatedRobot& robot : drawn_.things().robots) {
      const PatternFit fit =
          fitter_.fit(frame, {robot.x_mm + 2, robot.y_mm - 2, robot.orientation_rad}, kHeightMm, kPasses);
      ghosts += fit.dots[static_cast<std::size_t>(dot)].seen ? 1 : 0;
      EXPECT_LT(std::hypot(fit.pose.x_mm - robot.x_mm, fit.pose.y_mm - robot.y_mm), 1);
      EXPECT_LT(turn_between(fit.pose.angle_rad, robot.orientation_rad), 1 * kDegree);
    }
  }
  EXPECT_EQ(ghosts, 0);
}

TEST_P(PatternFitIn, FindsTheCentreDotAndTheHeadingWithoutRegions) {
  add_robots();
  const auto frame = this->frame();
  for (const SimulatedRobot& robot : drawn_.things().robots) {
    const auto center = fitter_.fit_center(frame, robot.x_mm + 4, robot.y_mm + 4, kHeightMm);
    ASSERT_TRUE(center.seen);
    EXPECT_LT(std::hypot(center.x_mm - robot.x_mm, center.y_mm - robot.y_mm), 1.5);
    std::array<double, PatternFitter::kMaxHeadings> headings{};
    const std::size_t count = fitter_.find_headings(frame, center.x_mm, center.y_mm, kHeightMm, headings);
    ASSERT_GT(count, 0U);
    EXPECT_LT(turn_between(headings[0], robot.orientation_rad), 6 * kDegree) << robot.id;
  }
}

TEST_P(PatternFitIn, NothingOnBareCarpet) {
  const auto frame = this->frame();
  for (int i = 0; i < 300; ++i) {
    const double x_mm = 100 + 8.1 * i, y_mm = 1700 * std::sin(i);
    const PatternFit fit = fitter_.fit(frame, {x_mm, y_mm, 0.1 * i}, kHeightMm, kPasses);
    EXPECT_FALSE(fit.seen == 5 && fit.rms_mm < 6) << x_mm << ", " << y_mm;
  }
}

TEST_P(PatternFitIn, OutOfSightThereIsNothing) {
  add_robots();
  const auto frame = this->frame();
  for (const double x_mm : {-5000.0, 20000.0, 1e6}) {
    EXPECT_EQ(fitter_.fit(frame, {x_mm, 0, 0}, kHeightMm, kPasses).seen, 0);
    EXPECT_FALSE(fitter_.fit_center(frame, x_mm, 0, kHeightMm).seen);
    std::array<double, PatternFitter::kMaxHeadings> headings{};
    EXPECT_EQ(fitter_.find_headings(frame, x_mm, 0, kHeightMm, headings), 0U);
  }
  // A plane above the camera.
  EXPECT_EQ(fitter_.fit(frame, {1250, 0, 0}, 5000, kPasses).seen, 0);
}

TEST_P(PatternFitIn, CountsTheDiscsItLooksAt) {
  add_robots();
  const auto frame = this->frame();
  const SimulatedRobot& robot = drawn_.things().robots[0];
  fitter_.fit(frame, {robot.x_mm, robot.y_mm, robot.orientation_rad}, kHeightMm, 1);
  EXPECT_EQ(fitter_.work(), 5);
  fitter_.reset_work();
  EXPECT_EQ(fitter_.work(), 0);
}

INSTANTIATE_TEST_SUITE_P(Formats, PatternFitIn, ::testing::ValuesIn(kColorFormats),
                         [](const auto& param) { return std::string(name_of(param.param)); });

TEST(PatternFit, NothingInAPictureWithoutColours) {
  DrawnScene drawn(plain_options(PixelFormat::kMono8));
  drawn.add_robot(Team::kBlue, 3, 1250, 300, 0.4);
  const ImageView view = drawn.image().view();
  const PatternFitter::Frame frame{view, *drawn.scene().camera, league_patterns(), drawn.lut(), 0.55};
  PatternFitter fitter;
  EXPECT_EQ(fitter.fit(frame, {1250, 300, 0.4}, kHeightMm, kPasses).seen, 0);
  EXPECT_FALSE(fitter.fit_center(frame, 1250, 300, kHeightMm).seen);
  std::array<double, PatternFitter::kMaxHeadings> headings{};
  EXPECT_EQ(fitter.find_headings(frame, 1250, 300, kHeightMm, headings), 0U);
}

}  // namespace
}  // namespace sslv::pattern_fit_test
