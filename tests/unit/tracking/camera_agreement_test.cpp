// SPDX-License-Identifier: Apache-2.0
#include "tracking/agreement.h"

#include <cmath>

#include <gtest/gtest.h>

namespace sslv {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

/// Two cameras over the halfway line, and robots that drive about where both see them.
class TwoCameras : public testing::Test {
 protected:
  TwoCameras() {
    agreement_.set_camera(0, {-2000, 0, 4000});
    agreement_.set_camera(1, {2000, 0, 4000});
  }
  static Vector2d place(int robot, double t_s) {
    return {400 * std::sin(0.7 * t_s + robot), 1500 * std::sin(0.31 * t_s + 2 * robot)};
  }

  /// Camera 1 sees all of it by `off` elsewhere, and says times that are `late_s` too late.
  void play(double seconds, const Vector2d& off, double late_s = 0) {
    const double until_s = t_s_ + seconds;
    for (; t_s_ < until_s; t_s_ += 0.01) {
      for (int id = 0; id < 6; ++id) {
        const RobotName robot{Team::kYellow, id};
        agreement_.see(0, {robot, place(id, t_s_), 140, t_s_});
        agreement_.see(1, {robot, place(id, t_s_ + 0.005) + off, 140, t_s_ + 0.005 + late_s});
      }
      agreement_.follow(0.01);
    }
  }
  /// What is left between the cameras, of a robot that one of them sees there and the other by `off` aside.
  double apart_mm(const Vector2d& at, const Vector2d& off) const {
    const auto left = [&](int camera, const Vector2d& seen) -> Vector2d {
      return seen - agreement_.error_of(camera, seen) - agreement_.height_error_of(camera, kRobot, seen, 140);
    };
    return (left(0, at) - left(1, at + off)).norm();
  }

  static constexpr RobotName kRobot{Team::kYellow, 4};
  CameraAgreement agreement_;
  double t_s_ = 100;
};

TEST_F(TwoCameras, AreBroughtTogether) {
  const Vector2d off(2, -1);
  play(25, off);
  EXPECT_LT(apart_mm({0, 0}, off), 0.3);
  EXPECT_LT(apart_mm({200, 1000}, off), 0.3);
}

TEST_F(TwoCameras, ClocksAreToldFromPlaces) {
  play(60, {0, 0}, 0.6e-3);
  EXPECT_NEAR(agreement_.time_offset_s(1) - agreement_.time_offset_s(0), 0.6e-3, 0.15e-3);
  EXPECT_LT(apart_mm({0, 0}, {0, 0}), 0.3);
}

TEST_F(TwoCameras, ThatWereBumpedAreLearntAgain) {
  play(25, {0, 0});
  const Vector2d bump(9, 6);
  play(25, bump);
  EXPECT_LT(apart_mm({0, 0}, bump), 1);
}

TEST_F(TwoCameras, ThatDriftAreFollowedHoweverLongTheyAgreed) {
  play(300, {0, 0});
  const Vector2d drift(1.5, -1.5);  // too little to be a surprise
  play(60, drift);
  EXPECT_LT(apart_mm({0, 0}, drift), 0.5);
}

TEST_F(TwoCameras, DifferencesAreShownWhereBothSeeRobots) {
  play(60, {3, 4});
  int parts = 0;
  agreement_.for_differences([&](const CameraAgreement::Difference& one) {
    if (one.samples < 30) return;
    ++parts;
    EXPECT_EQ(one.camera, 0);
    EXPECT_EQ(one.other, 1);
    EXPECT_NEAR(one.off_mm.x(), -3, 0.5) << one.place_mm.transpose();
    EXPECT_NEAR(one.off_mm.y(), -4, 0.5) << one.place_mm.transpose();
    EXPECT_LT(std::abs(one.place_mm.x()), 600);
  });
  EXPECT_GT(parts, 5);
}

TEST_F(TwoCameras, ABumpShowsInTheDifferencesWithinHalfAMinute) {
  play(120, {0, 0});
  for (const double bump_mm : {5.5, 9.0, 12.0}) {
    play(30, {bump_mm, 0});
    int parts = 0, right = 0;
    agreement_.for_differences([&](const CameraAgreement::Difference& one) {
      if (one.samples < 30) return;
      ++parts;
      if (std::abs(one.off_mm.x() + bump_mm) < 1) ++right;
    });
    EXPECT_GE(parts, 5) << bump_mm;
    EXPECT_GT(2 * right, parts) << bump_mm;
  }
}

TEST_F(TwoCameras, ANewCalibrationForgetsWhatWasLearntOfTheOldOne) {
  play(25, {2, -1});
  agreement_.set_camera(1, {2000.5, 0, 4000});
  int parts = 0;
  agreement_.for_differences([&](const auto&) { ++parts; });
  EXPECT_EQ(parts, 0);
  play(25, {0, 0});
  EXPECT_LT(apart_mm({0, 0}, {0, 0}), 0.4);
}

TEST_F(TwoCameras, ARobotThatWasMisreadChangesNothing) {
  play(25, {0, 0});
  const double before = apart_mm({0, 0}, {0, 0});
  for (int i = 0; i < 100; ++i, t_s_ += 0.01) {
    agreement_.see(0, {kRobot, {0, 0}, 140, t_s_});
    agreement_.see(1, {kRobot, {900, 0}, 140, t_s_ + 0.005});
  }
  agreement_.follow(1);
  EXPECT_NEAR(apart_mm({0, 0}, {0, 0}), before, 0.2);
}

TEST_F(TwoCameras, NumbersOfRobotsHaveAnEnd) {
  for (int round = 0; round < 3; ++round) {
    for (int id = 0; id < 256; ++id, t_s_ += 0.01) agreement_.see(0, {{Team::kBlue, id}, {0, 0}, 140, t_s_});
  }
  int robots = 0;
  agreement_.for_heights([&](const auto&, const auto&) { ++robots; });
  EXPECT_LE(robots, 64);
  play(25, {2, -1});
  EXPECT_LT(apart_mm({0, 0}, {2, -1}), 0.3) << "and those that are there are still of use";
}

TEST(Agreement, KeepsWhatAnotherComputersCameraSawApart) {
  CameraSightings image;
  image.camera_mm = {0, 0, 4000};
  image.robots.push_back({Team::kBlue, 3, {0, 0}, 0, 140, Eigen::Matrix2d::Identity(), 0.01});
  Observations seen;
  CameraAgreement learnt;
  Agreement agreement;
  for (const bool is_of_other : {true, false}) {
    image.is_of_other_computer = is_of_other;
    agreement.process({}, image, {.t_s = 1000}, seen, learnt);
    ASSERT_EQ(seen.robots.size(), 1U);
    EXPECT_EQ(seen.robots[0].is_of_other_computer, is_of_other);
  }
}

}  // namespace
}  // namespace sslv
