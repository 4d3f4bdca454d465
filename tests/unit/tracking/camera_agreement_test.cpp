// SPDX-License-Identifier: Apache-2.0
#include "tracking/agreement.h"

#include <algorithm>
#include <cmath>
#include <vector>

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

TEST_F(TwoCameras, ARobotAsHighAsAnotherCameraHarmsNothing) {
  play(25, {2, -1});
  // A camera hangs at 500 mm, and another one says that it sees a robot of that height.
  agreement_.set_camera(21, {0, 0, 500}, true);
  for (int i = 0; i < 4; ++i, t_s_ += 0.01) {
    agreement_.see(21, {kRobot, {10, 0}, 140, t_s_});
    agreement_.see(0, {kRobot, {10, 0}, 500, t_s_ + 0.005});
  }
  agreement_.follow(1);
  EXPECT_LT(apart_mm({0, 0}, {2, -1}), 0.5) << "what was known is still known";
  EXPECT_TRUE(agreement_.error_of(21, {0, 0}).allFinite());
  EXPECT_TRUE(agreement_.height_error_of(21, kRobot, {900, 0}, 500).allFinite());
  play(25, {2, -1});
  EXPECT_LT(apart_mm({0, 0}, {2, -1}), 0.3);
  EXPECT_EQ(agreement_.repaired(), 0U);
}

TEST_F(TwoCameras, WhatIsNoNumberIsNotLearnt) {
  play(25, {2, -1});
  const double nan = std::nan("");
  for (int i = 0; i < 4; ++i, t_s_ += 0.01) {
    agreement_.see(0, {kRobot, {0, nan}, 140, t_s_});
    agreement_.see(1, {kRobot, {0, nan}, 140, t_s_ + 0.005});
  }
  play(1, {2, -1});
  EXPECT_LT(apart_mm({0, 0}, {2, -1}), 0.3);
  EXPECT_EQ(agreement_.repaired(), 0U);
}

TEST_F(TwoCameras, AFilterThatIsNoNumberBeginsAgain) {
  play(25, {2, -1});
  agreement_.set_camera(1, {std::nan(""), 0, 4000});
  play(0.1, {2, -1});
  EXPECT_GT(agreement_.repaired(), 0U);
  // As before every image.
  agreement_.set_camera(0, {-2000, 0, 4000});
  agreement_.set_camera(1, {2000, 0, 4000});
  play(25, {2, -1});
  EXPECT_LT(apart_mm({0, 0}, {2, -1}), 0.3);
}

/// Cameras of this computer and of others, and robots that drive about where all of them see them.
class ManyCameras : public testing::Test {
 protected:
  struct Camera {
    int id;
    bool is_of_other_computer;
    Vector2d off_mm;
    double late_s = 0;
    double swings_mm = 0;  // there and back, so that it surprises again and again
  };
  static constexpr RobotName kRobot{Team::kYellow, 4};

  static Vector2d place(int robot, double t_s) {
    return {900 * std::sin(0.7 * t_s + robot), 1500 * std::sin(0.31 * t_s + 2 * robot)};
  }
  static Vector3d center(int camera) { return {camera % 2 == 0 ? -1500.0 : 1500.0, 400.0 * camera, 4000}; }

  CameraAgreement played(const std::vector<Camera>& cameras, double seconds = 60) const {
    CameraAgreement agreement;
    play(agreement, cameras, 100, seconds);
    return agreement;
  }
  static void play(CameraAgreement& agreement, const std::vector<Camera>& cameras, double from_s,
                   double seconds) {
    for (double t_s = from_s; t_s < from_s + seconds; t_s += 0.01) {
      for (int id = 0; id < 6; ++id) {
        double seen_s = t_s;
        for (const Camera& camera : cameras) {
          agreement.set_camera(camera.id, center(camera.id), camera.is_of_other_computer);
          const Vector2d swings(camera.swings_mm * std::sin(9 * t_s + id), 0);
          agreement.see(
              camera.id,
              {{Team::kYellow, id}, place(id, seen_s) + camera.off_mm + swings, 140, seen_s + camera.late_s});
          seen_s += 0.002;
        }
      }
      agreement.follow(0.01);
    }
  }
  /// What is taken off what a camera sees of a robot there, whatever its height is taken for.
  static Vector2d taken_off(const CameraAgreement& agreement, int camera, const Vector2d& at = {0, 0}) {
    return agreement.error_of(camera, at) + agreement.height_error_of(camera, kRobot, at, 140);
  }
  /// How far others move it, over the field that the camera sees.
  static double moved_mm(const CameraAgreement& with, const CameraAgreement& without, int camera) {
    double out = 0;
    for (const double x : {-900.0, 0.0, 900.0}) {
      for (const double y : {-1500.0, 0.0, 1500.0})
        out = std::max(out, (taken_off(with, camera, {x, y}) - taken_off(without, camera, {x, y})).norm());
    }
    return out;
  }
  /// What is left between two cameras.
  static double apart_mm(const CameraAgreement& agreement, const Camera& a, const Camera& b) {
    return (a.off_mm - taken_off(agreement, a.id, a.off_mm) - b.off_mm + taken_off(agreement, b.id, b.off_mm))
        .norm();
  }
  /// As a calibration may be off before anything is known.
  static constexpr double kAllowedMm = 4;
};

TEST_F(ManyCameras, OneOfOursIsNotPulledByAComputerThatIsFarOff) {
  const Camera ours{0, false, {0, 0}};
  for (const double off_mm : {6.0, 10.0, 30.0, 100.0, 140.0}) {
    const CameraAgreement agreement = played({ours, {21, true, {off_mm, 0}}});
    EXPECT_LT(moved_mm(agreement, {}, 0), off_mm < 20 ? kAllowedMm : 1) << off_mm;
    EXPECT_LT(apart_mm(agreement, ours, {21, true, {off_mm, 0}}), 1)
        << off_mm << ": it is that one that is off";
    EXPECT_LT(std::abs(agreement.time_offset_s(0)), 0.6e-3) << off_mm;
  }
}

TEST_F(ManyCameras, TwoOfOursAreNotPulledByAComputerThatIsFarOff) {
  const Camera a{0, false, {1, 0}}, b{1, false, {-1, 0.5}};
  const CameraAgreement alone = played({a, b});
  for (const double off_mm : {6.0, 10.0, 30.0, 100.0, 140.0}) {
    const CameraAgreement agreement = played({a, b, {21, true, {off_mm, 0}}});
    for (const int camera : {0, 1})
      EXPECT_LT(moved_mm(agreement, alone, camera), off_mm < 20 ? kAllowedMm : 1) << off_mm;
    EXPECT_LT(apart_mm(agreement, a, b), 0.3) << off_mm << ": what ours say of each other holds";
  }
}

TEST_F(ManyCameras, AComputerThatMovesOnAndOnPullsNobodyAlong) {
  const Camera ours{0, false, {0, 0}};
  CameraAgreement agreement;
  double t_s = 100;
  // So little at a time that it is no surprise, and with time for what was learnt to be doubted again.
  for (int step = 1; step <= 12; ++step) {
    play(agreement, {ours, {21, true, {4.0 * step, 0}}}, t_s, 10);
    t_s += 10;
    for (int i = 0; i < 60; ++i, t_s += 1) agreement.follow(1);
  }
  play(agreement, {ours, {21, true, {48, 0}}}, t_s, 10);
  EXPECT_LT(moved_mm(agreement, {}, 0), kAllowedMm);
}

TEST_F(ManyCameras, AComputerWithoutRhymeOrReasonPullsNobody) {
  const Camera a{0, false, {1, 0}}, b{1, false, {-1, 0.5}};
  const CameraAgreement alone = played({a, b});
  const CameraAgreement agreement =
      played({a, b, {21, true, {40, -20}, 3e-3, 60}, {22, true, {-70, 30}, -3e-3, 40}});
  for (const int camera : {0, 1}) EXPECT_LT(moved_mm(agreement, alone, camera), kAllowedMm) << camera;
  EXPECT_LT(apart_mm(agreement, a, b), 0.5);
}

TEST_F(ManyCameras, TwoHonestComputersAgreeAndMeetInTheMiddle) {
  const Camera a{0, false, {0.8, -0.3}}, b{1, true, {-0.8, 0.3}};
  Camera ours_there = b, theirs_there = a;  // as the other computer has it
  ours_there.is_of_other_computer = false;
  theirs_there.is_of_other_computer = true;
  Camera own_b = b;
  own_b.is_of_other_computer = false;
  const CameraAgreement as_one = played({a, own_b});
  const CameraAgreement here = played({a, b}), there = played({theirs_there, ours_there});
  EXPECT_LT(apart_mm(as_one, a, own_b), 0.3);
  EXPECT_LT(apart_mm(here, a, b), 0.3);
  EXPECT_LT(apart_mm(there, a, b), 0.3);
  // And both computers have a robot at the same place.
  for (const int camera : {0, 1})
    EXPECT_LT((taken_off(here, camera) - taken_off(there, camera)).norm(), 0.3) << camera;
}

TEST_F(ManyCameras, OfTwoHonestComputersAgreeAsThoseOfOne) {
  const std::vector<Vector2d> offs{{1.5, -1}, {-0.5, 2}, {-2, 0.5}, {1, -2}};
  std::vector<Camera> as_one, as_two;
  for (int id = 0; id < 4; ++id) {
    as_one.push_back({id, false, offs[static_cast<std::size_t>(id)]});
    as_two.push_back({id, id >= 2, offs[static_cast<std::size_t>(id)]});
  }
  const CameraAgreement one = played(as_one), two = played(as_two);
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j) {
      EXPECT_LT(apart_mm(one, as_one[i], as_one[j]), 0.3) << i << " " << j;
      EXPECT_LT(apart_mm(two, as_two[i], as_two[j]), 0.3) << i << " " << j;
    }
  }
}

TEST_F(ManyCameras, ABumpedCameraOfAnotherComputerIsLearntAgainAndOursAreKept) {
  const Camera ours{0, false, {0, 0}};
  CameraAgreement agreement = played({ours, {21, true, {1, 0}}});
  const CameraAgreement before = agreement;
  play(agreement, {ours, {21, true, {60, 40}}}, 160, 60);
  EXPECT_LT(moved_mm(agreement, before, 0), 1);
  EXPECT_LT(apart_mm(agreement, ours, {21, true, {60, 40}}), 1);
}

TEST_F(ManyCameras, ThatAreSilentMakeRoom) {
  CameraAgreement agreement;
  for (int id = 20; id < 120; ++id) agreement.set_camera(id, center(id), true);
  int cameras = 0;
  agreement.for_cameras([&](int) { ++cameras; });
  EXPECT_LE(cameras, 32);
  const Camera a{0, false, {2, 0}}, b{1, false, {-2, 0}};
  play(agreement, {a, b}, 100, 60);
  EXPECT_LT(apart_mm(agreement, a, b), 0.3) << "our own come late";
  // And those of others that are there, once.
  const Camera other{200, true, {0, 2}};
  play(agreement, {a, b, other}, 160, 60);
  EXPECT_LT(apart_mm(agreement, a, other), 0.3);
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
