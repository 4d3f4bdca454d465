// SPDX-License-Identifier: Apache-2.0
#include "tracking/gather.h"

#include "geometry/limits.h"
#include "pipeline/validate.h"

#include <limits>

#include <gtest/gtest.h>

namespace sslv::gather_test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

struct FixedClock : FieldClock {
  double t_s = 1000;
  double now_s() const noexcept override { return t_s; }
};

class Gathered : public testing::Test {
 protected:
  Gathered() {
    arrived_.image.camera = 2;
    arrived_.image.t_capture_s = 999.985;
    arrived_.image.camera_mm = {0, 0, 4000};
    add_robot(7, {100, 200});
    arrived_.image.balls.push_back({{1, 2}, Eigen::Matrix2d::Identity() * 0.04, 0.9});
  }
  void add_robot(int id, const Eigen::Vector2d& place_mm) {
    arrived_.image.robots.push_back(
        {Team::kBlue, id, place_mm, 0.5, 140, Eigen::Matrix2d::Identity() * 0.01, 1e-3});
  }
  /// Runs behind drop_invalid(), as for everything that arrives.
  void gather() {
    ArrivedSightings arrived = arrived_;
    const InvalidCounts dropped = drop_invalid(arrived.image);
    arrived.left_out = dropped.robots + dropped.balls;
    gather_.process({}, field_, clock_, arrived, out_, left_out_);
  }

  Gather gather_;
  FieldSize field_;
  FixedClock clock_;
  ArrivedSightings arrived_;
  CameraSightings out_;
  LeftOut left_out_;
};

TEST_F(Gathered, KeepsValidSightings) {
  gather();
  EXPECT_TRUE(out_.is_taken);
  EXPECT_EQ(out_.camera, 2);
  ASSERT_EQ(out_.robots.size(), 1U);
  EXPECT_EQ(out_.robots[0].place_cov_mm2(0, 0), 0.01);
  EXPECT_EQ(out_.balls.size(), 1U);
  EXPECT_EQ(left_out_.sightings, 0U);
}

TEST_F(Gathered, SaysHowSureOtherComputersAreAsTheSettingsDo) {
  arrived_.image.is_of_other_computer = true;
  arrived_.image.robots[0].place_cov_mm2.setZero();
  Gather::Params params;
  params.robot_sigma_mm = 3;
  gather_.process(params, field_, clock_, arrived_, out_, left_out_);
  EXPECT_TRUE(out_.is_of_other_computer);
  EXPECT_EQ(out_.robots.at(0).place_cov_mm2(0, 0), 9);
  EXPECT_GT(out_.robots.at(0).orientation_sigma_rad, 0);
  EXPECT_GT(out_.balls.at(0).place_cov_mm2(1, 1), 0);
}

TEST_F(Gathered, DropsInvalidSightings) {
  add_robot(8, {kNan, 0});
  add_robot(9, {50'000, 0});
  add_robot(-1, {0, 0});
  add_robot(4000, {0, 0});
  add_robot(7, {3000, 0});  // the first robot has that id
  add_robot(10, {0, 0});
  arrived_.image.robots.back().orientation_rad = kNan;
  add_robot(11, {0, 0});
  arrived_.image.robots.back().height_mm = 5000;  // above the camera
  arrived_.image.balls.push_back({{0, kNan}, Eigen::Matrix2d::Identity(), 1});
  gather();
  EXPECT_TRUE(out_.is_taken);
  EXPECT_EQ(out_.robots.size(), 1U);
  EXPECT_EQ(out_.balls.size(), 1U);
  EXPECT_EQ(left_out_.sightings, 8U);
}

TEST_F(Gathered, LimitsTheNumberOfRobots) {
  arrived_.image.robots.clear();
  for (int i = 0; i < 1000; ++i) add_robot(i % 256, {0, 0});
  gather();
  EXPECT_EQ(out_.robots.size(), limits::kMaxRobots);
}

TEST_F(Gathered, DropsImagesOfAnotherTime) {
  for (const double t_s : {900.0, 1100.0, kNan, 0.0, 1e300}) {
    arrived_.image.t_capture_s = t_s;
    gather();
    EXPECT_FALSE(out_.is_taken) << t_s;
    EXPECT_TRUE(out_.robots.empty());
  }
  EXPECT_EQ(left_out_.images_off_time, 4U) << "what is no time at all stays outside";
  EXPECT_EQ(left_out_.why, LeftOut::Why::kTime);
  EXPECT_EQ(left_out_.camera, 2);
  arrived_.image.t_capture_s = 999.99;
  gather();
  EXPECT_TRUE(out_.is_taken) << "once its clock is right again";
}

TEST_F(Gathered, LimitsTheNumberOfCameras) {
  arrived_.image.is_of_other_computer = true;
  for (int camera = 0; camera < 100; ++camera) {
    arrived_.image.camera = camera;
    gather();
  }
  arrived_.image.is_of_other_computer = false;
  arrived_.image.camera = 200;
  gather();
  EXPECT_TRUE(out_.is_taken) << "our own camera, which comes late";
  arrived_.image.is_of_other_computer = true;
  EXPECT_EQ(left_out_.images_of_too_many, 100 - limits::kMaxCameras);
  int taken = 0;
  for (int camera = 0; camera < 32; ++camera) {
    arrived_.image.camera = camera;
    gather();
    taken += out_.is_taken;
  }
  EXPECT_EQ(taken, 31) << "those that were there first go on, but for one that made room for our own";
  clock_.t_s += 60;
  arrived_.image.t_capture_s += 60;
  arrived_.image.camera = 99;
  gather();
  EXPECT_TRUE(out_.is_taken) << "when others are gone";
}

TEST_F(Gathered, SaysHowCertainASightingIsWhereItsCameraDoesNot) {
  for (const double sigma_rad : {0.0, -1.0, kNan, std::numeric_limits<double>::infinity()}) {
    arrived_.image.robots[0].orientation_sigma_rad = sigma_rad;
    gather();
    ASSERT_EQ(out_.robots.size(), 1U);
    EXPECT_GT(out_.robots[0].orientation_sigma_rad, 0);
    EXPECT_LT(out_.robots[0].orientation_sigma_rad, 1);
  }
}

TEST_F(Gathered, DropsCamerasAtInvalidPositions) {
  for (const double z_mm : {0.0, -4000.0, kNan, 1e9}) {
    arrived_.image.camera_mm.z() = z_mm;
    left_out_ = {};
    gather();
    EXPECT_FALSE(out_.is_taken) << z_mm;
    EXPECT_EQ(left_out_.sightings, 2U) << z_mm << ": what it saw is counted";
  }
}

}  // namespace
}  // namespace sslv::gather_test
