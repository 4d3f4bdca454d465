// SPDX-License-Identifier: Apache-2.0
#include "tracking/agreement.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace sslv::camera_agreement_test {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

/// Two cameras above the halfway line, and robots that move where both see them.
class TwoCameras : public testing::Test {
 protected:
  TwoCameras() {
    agreement_.set_camera(0, {-2000, 0, 4000});
    agreement_.set_camera(1, {2000, 0, 4000});
  }
  static Vector2d place(int robot, double t_s) {
    return {400 * std::sin(0.7 * t_s + robot), 1500 * std::sin(0.31 * t_s + 2 * robot)};
  }

  /// Camera 1 sees everything shifted by `off` (mm), and its times are `late_s` too late.
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
  /// The remaining difference between two cameras, one of which sees a robot at `at` and the other at `at` +
  /// `off`.
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

TEST_F(TwoCameras, AreAligned) {
  const Vector2d off(2, -1);
  play(25, off);
  EXPECT_LT(apart_mm({0, 0}, off), 0.3);
  EXPECT_LT(apart_mm({200, 1000}, off), 0.3);
}

/// Both cameras see everything 20 mm too far out, which only their overlap shows. What they have in common,
/// and what no other camera sees, is not made worse.
TEST_F(TwoCameras, ThatSeeTooFarOutAreCorrectedOnlyWhereBothSee) {
  const Vector2d centers[]{{-2000, 0}, {2000, 0}};
  const auto seen_by = [&](int camera, const Vector2d& at) -> Vector2d {
    return at + 20 * (at - centers[camera]).normalized();
  };
  for (const double until_s = t_s_ + 200; t_s_ < until_s; t_s_ += 0.01) {
    for (int id = 0; id < 6; ++id) {
      const RobotName robot{Team::kYellow, id};
      agreement_.see(0, {robot, seen_by(0, place(id, t_s_)), 140, t_s_});
      agreement_.see(1, {robot, seen_by(1, place(id, t_s_ + 0.005)), 140, t_s_ + 0.005});
    }
    agreement_.follow(0.01);
  }
  for (const double y_mm : {-1000.0, 0.0, 1000.0}) {
    const Vector2d at(100, y_mm), a = seen_by(0, at), b = seen_by(1, at);
    EXPECT_LT(((a - agreement_.error_of(0, a)) - (b - agreement_.error_of(1, b))).norm(), 14) << y_mm;
  }
  constexpr double kFarMm = 4;
  for (const double x_mm : {3000.0, 5000.0}) {
    EXPECT_LT(agreement_.error_of(0, {-x_mm, 500}).norm(), kFarMm) << x_mm;
    EXPECT_LT(agreement_.error_of(1, {x_mm, 500}).norm(), kFarMm) << x_mm;
  }
}

TEST_F(TwoCameras, ClockOffsetsAreSeparatedFromPositions) {
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
  const Vector2d drift(1.5, -1.5);  // too small to be an outlier
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

TEST_F(TwoCameras, TheNumberOfRobotsIsLimited) {
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
  // One camera hangs at 500 mm, and another one reports a robot of that height. The test uses a new robot,
  // because a new robot is compared in each image.
  const RobotName high{Team::kBlue, 9};
  agreement_.set_camera(21, {0, 0, 500}, true);
  for (int i = 0; i < 4; ++i, t_s_ += 0.01) {
    agreement_.see(21, {high, {10, 0}, 140, t_s_});
    agreement_.see(0, {high, {10, 0}, 500, t_s_ + 0.005});
  }
  agreement_.follow(1);
  EXPECT_LT(apart_mm({0, 0}, {2, -1}), 0.5) << "what was known is still known";
  EXPECT_TRUE(agreement_.error_of(21, {0, 0}).allFinite());
  EXPECT_TRUE(agreement_.height_error_of(21, high, {900, 0}, 500).allFinite());
  play(25, {2, -1});
  EXPECT_LT(apart_mm({0, 0}, {2, -1}), 0.3);
  EXPECT_EQ(agreement_.repaired(), 0U);
}

TEST_F(TwoCameras, NonFinitePositionsAreNotLearnt) {
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

TEST_F(TwoCameras, ANonFiniteFilterIsReset) {
  play(25, {2, -1});
  agreement_.set_camera(1, {std::nan(""), 0, 4000});
  play(0.1, {2, -1});
  EXPECT_GT(agreement_.repaired(), 0U);
  // Positions are set before every image.
  agreement_.set_camera(0, {-2000, 0, 4000});
  agreement_.set_camera(1, {2000, 0, 4000});
  play(25, {2, -1});
  EXPECT_LT(apart_mm({0, 0}, {2, -1}), 0.3);
}

/// Cameras of this computer and of others, and robots that move where all of them see them.
class ManyCameras : public testing::Test {
 protected:
  struct Camera {
    int id;
    bool is_of_other_computer;
    Vector2d off_mm;
    double late_s = 0;
    double swings_mm = 0;  // amplitude of a swing that repeatedly causes outliers
  };
  static constexpr RobotName kRobot{Team::kYellow, 4};

  static Vector2d place(int robot, double t_s) {
    return {900 * std::sin(0.7 * t_s + robot), 1500 * std::sin(0.31 * t_s + 2 * robot)};
  }
  static Vector3d center(int camera) {
    return {camera % 2 == 0 ? -1500.0 : 1500.0, 400.0 * (camera % 8), 4000};
  }

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
  /// The whole correction of a robot seen there, whatever its assumed height.
  static Vector2d taken_off(const CameraAgreement& agreement, int camera, const Vector2d& at = {0, 0}) {
    return agreement.error_of(camera, at) + agreement.height_error_of(camera, kRobot, at, 140);
  }
  /// The largest change of a camera's correction between two states, over the field that it sees.
  static double moved_mm(const CameraAgreement& with, const CameraAgreement& without, int camera) {
    double out = 0;
    for (const double x : {-900.0, 0.0, 900.0}) {
      for (const double y : {-1500.0, 0.0, 1500.0})
        out = std::max(out, (taken_off(with, camera, {x, y}) - taken_off(without, camera, {x, y})).norm());
    }
    return out;
  }
  /// The remaining difference between two cameras.
  static double apart_mm(const CameraAgreement& agreement, const Camera& a, const Camera& b) {
    return (a.off_mm - taken_off(agreement, a.id, a.off_mm) - b.off_mm + taken_off(agreement, b.id, b.off_mm))
        .norm();
  }
  static constexpr double kExact_mm = 1e-9;
};

TEST_F(ManyCameras, OneOfOursIsNotMovedByAnotherComputer) {
  const Camera ours{0, false, {0, 0}};
  for (const double off_mm : {1.0, 6.0, 30.0, 100.0, 140.0}) {
    const Camera other{21, true, {off_mm, 0}};
    const CameraAgreement agreement = played({ours, other});
    EXPECT_LT(moved_mm(agreement, {}, 0), kExact_mm) << off_mm;
    EXPECT_EQ(agreement.time_offset_s(0), 0) << off_mm;
    EXPECT_LT(apart_mm(agreement, ours, other), 2) << off_mm << ": that one is corrected";
  }
}

TEST_F(ManyCameras, TwoOfOursAreNotMovedByOtherComputers) {
  const Camera a{0, false, {1, 0}}, b{1, false, {-1, 0.5}};
  const CameraAgreement alone = played({a, b});
  EXPECT_LT(apart_mm(alone, a, b), 0.3);
  const auto expect_as_alone = [&](const std::vector<Camera>& others) {
    std::vector<Camera> all{a, b};
    all.insert(all.end(), others.begin(), others.end());
    const CameraAgreement agreement = played(all);
    for (const int camera : {0, 1}) {
      EXPECT_LT(moved_mm(agreement, alone, camera), kExact_mm) << others[0].off_mm.x();
      EXPECT_EQ(agreement.time_offset_s(camera), alone.time_offset_s(camera));
    }
  };
  for (const double off_mm : {6.0, 30.0, 100.0, 140.0}) expect_as_alone({{21, true, {off_mm, 0}}});
  // Inconsistent in position and time.
  expect_as_alone({{21, true, {40, -20}, 3e-3, 60}, {22, true, {-70, 30}, -3e-3, 40}});
}

TEST_F(ManyCameras, AnHonestComputerIsAlignedWithOurs) {
  const std::vector<Vector2d> offs{{1.5, -1}, {-0.5, 2}, {-2, 0.5}, {1, -2}};
  std::vector<Camera> cameras;
  for (int id = 0; id < 4; ++id) cameras.push_back({id, id >= 2, offs[static_cast<std::size_t>(id)]});
  const CameraAgreement agreement = played(cameras);
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j)
      EXPECT_LT(apart_mm(agreement, cameras[i], cameras[j]), 0.3) << i << " " << j;
  }
}

TEST_F(ManyCameras, ABumpedCameraOfAnotherComputerIsLearntAgain) {
  const Camera ours{0, false, {0, 0}}, bumped{21, true, {60, 40}};
  CameraAgreement agreement = played({ours, {21, true, {1, 0}}});
  play(agreement, {ours, bumped}, 160, 60);
  EXPECT_LT(moved_mm(agreement, {}, 0), kExact_mm);
  EXPECT_LT(apart_mm(agreement, ours, bumped), 1);
}

TEST_F(ManyCameras, RobotsOfOtherComputersLeaveRoomForOurs) {
  CameraAgreement agreement;
  agreement.set_camera(21, center(21), true);
  const Camera a{0, false, {2, 0}}, b{1, false, {-2, 0}};
  for (int i = 0; i < 2500; ++i) {
    const double t_s = 100 + 0.01 * i;
    for (int id = 0; id < 256; ++id) agreement.see(21, {{Team::kBlue, id}, {0, 0}, 140, t_s});
    play(agreement, {a, b}, t_s, 0.005);
  }
  EXPECT_LT(apart_mm(agreement, a, b), 0.3);
}

TEST_F(ManyCameras, RobotsOfOtherComputersPushNoneOfOursOut) {
  CameraAgreement agreement;
  agreement.set_camera(0, center(0));
  agreement.set_camera(21, center(21), true);
  agreement.see(0, {kRobot, {0, 0}, 140, 100});
  for (int id = 0; id < 200; ++id) agreement.see(21, {{Team::kBlue, id}, {0, 0}, 140, 100.0 + 2 * id});
  EXPECT_TRUE(agreement.height_of(kRobot)) << "ours was not seen for minutes, as in a break";
  EXPECT_TRUE(agreement.height_of({Team::kBlue, 190})) << "theirs make room for one another";
}

TEST_F(ManyCameras, DifferencesOfOtherComputersLeaveRoomForOurs) {
  CameraAgreement agreement;
  for (const int id : {0, 1, 21}) agreement.set_camera(id, {0, 0, 4000.0 + id}, id == 21);
  double t_s = 100;
  const auto compare_at = [&](int a, int b, int part) {
    const int column = part % 34 - 17, row = part / 34 - 17;
    const Vector2d at = CameraAgreement::kPartMm * Vector2d(column + 0.5, row + 0.5);
    agreement.see(a, {kRobot, at, 140, t_s});
    agreement.see(b, {kRobot, at, 140, t_s + 0.002});
    agreement.see(a, {kRobot, at, 140, t_s + 0.004});
    t_s += 0.2;
  };
  for (int part = 0; part < 34 * 34; ++part) compare_at(0, 21, part);
  for (int part = 0; part < 10; ++part) compare_at(0, 1, part);
  int others = 0, ours = 0;
  agreement.for_differences([&](const auto& one) { ++(one.other == 21 ? others : ours); });
  EXPECT_EQ(others, 512);
  EXPECT_EQ(ours, 10);
}

TEST_F(ManyCameras, ThatAreSilentMakeRoom) {
  CameraAgreement agreement;
  for (int id = 20; id < 120; ++id) agreement.set_camera(id, center(id), true);
  int cameras = 0;
  agreement.for_cameras([&](int) { ++cameras; });
  EXPECT_EQ(cameras, 32);
  const Camera a{0, false, {2, 0}}, b{1, false, {-2, 0}}, other{200, true, {0, 2}};
  play(agreement, {a, b, other}, 100, 25);
  EXPECT_LT(apart_mm(agreement, a, b), 0.3) << "our own come late";
  EXPECT_LT(apart_mm(agreement, a, other), 0.5) << "and so does another one that sends";
  for (int id = 0; id < 32; ++id) agreement.set_camera(id, center(id), id >= 2);
  agreement.for_cameras([](int id) { EXPECT_LT(id, 32) << "whatever robots those saw that are silent"; });
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
}  // namespace sslv::camera_agreement_test
