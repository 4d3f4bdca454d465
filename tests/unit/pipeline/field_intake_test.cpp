// SPDX-License-Identifier: Apache-2.0
#include "pipeline/field_intake.h"

#include "geometry/limits.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>

namespace sslv::field_intake_test {
namespace {

class Intake : public testing::Test {
 protected:
  Intake() {
    CameraCalibration calibration;  // 4 m above the field's centre
    calibration.q0 = 1;
    calibration.q3 = 0;
    calibration.tz = 4000;
    calibration.pixel_image_width = 640;
    calibration.pixel_image_height = 480;
    scene_.camera.emplace(calibration);
    robots_.robots.push_back({.team = Team::kBlue,
                              .id = 7,
                              .x_mm = 100,
                              .y_mm = -200,
                              .orientation_rad = 1,
                              .height_mm = 140,
                              .pixel_x = 1,
                              .pixel_y = 1,
                              .confidence = 0.9,
                              .place_cov = {0.01, 0.002, 0.04},
                              .orientation_sigma_rad = 0.001});
  }
  FrameInfo info(double t_s) const { return {.camera_id = 3, .number = 5, .times = {.t_capture_s = t_s}}; }

  /// The oldest image; its camera is -1 if there is none.
  ArrivedSightings take() {
    ArrivedSightings out;
    out.image.camera = -1;
    intake_.take([&](const ArrivedSightings& arrived) { out = arrived; });
    return out;
  }

  FieldIntake intake_;
  Scene scene_;
  RobotList robots_;
  BallList balls_;
};

TEST_F(Intake, DeliversSightingsWithTheirCovariance) {
  const auto queue = intake_.add();
  balls_.balls.push_back({.x_mm = 1,
                          .y_mm = 2,
                          .pixel_x = 0,
                          .pixel_y = 0,
                          .area_px = 60,
                          .confidence = 0.8,
                          .place_cov = {0.04, 0, 0.09},
                          .radius_mm = 22.5,
                          .radius_sigma_mm = 0.3});
  queue->hand_over(info(100), scene_, robots_, balls_);
  const ArrivedSightings got = take();
  EXPECT_EQ(got.image.camera, 3);
  EXPECT_EQ(got.image.frame_number, 5U);
  EXPECT_EQ(got.image.t_capture_s, 100);
  EXPECT_NEAR(got.image.camera_mm.z(), 4000, 1);
  EXPECT_FALSE(got.image.is_of_other_computer);
  ASSERT_EQ(got.image.robots.size(), 1U);
  const RobotSighting& robot = got.image.robots[0];
  EXPECT_EQ(robot.id, 7);
  EXPECT_EQ(robot.place_cov_mm2(0, 1), 0.002);
  EXPECT_EQ(robot.place_cov_mm2(1, 1), 0.04);
  EXPECT_EQ(robot.orientation_sigma_rad, 0.001);
  ASSERT_EQ(got.image.balls.size(), 1U);
  // It appears 22.5/21.5 times its size, so it is closer to the camera by that factor.
  EXPECT_NEAR(got.image.balls[0].height_mm, 21.5 + (4000 - 21.5) * (1 - 21.5 / 22.5), 1);
  EXPECT_NEAR(got.image.balls[0].height_sigma_mm, (4000 - 21.5) * 0.3 / 21.5, 60);
  EXPECT_EQ(take().image.camera, -1);
}

TEST_F(Intake, GivesTheOldestImageOfAllCamerasFirst) {
  const auto a = intake_.add(), b = intake_.add();
  a->hand_over(info(101), scene_, robots_, balls_);
  b->hand_over(info(100), scene_, robots_, balls_);
  a->hand_over(info(102), scene_, robots_, balls_);
  EXPECT_EQ(take().image.t_capture_s, 100);
  EXPECT_EQ(take().image.t_capture_s, 101);
  EXPECT_EQ(take().image.t_capture_s, 102);
}

TEST_F(Intake, KnowsWhatAnotherComputersCameraSaw) {
  const auto queue = intake_.add();
  ArrivedSightings heard;
  heard.image.camera = 6;
  heard.image.is_of_other_computer = true;
  queue->hand_over(heard);
  EXPECT_TRUE(take().image.is_of_other_computer);
  // Later images use the same slots.
  for (int i = 0; i < 100; ++i) {
    queue->hand_over(info(100 + i), scene_, robots_, balls_);
    EXPECT_FALSE(take().image.is_of_other_computer);
  }
}

TEST_F(Intake, TakesNothingOfACameraWithoutACalibration) {
  const auto queue = intake_.add();
  scene_.camera.reset();
  queue->hand_over(info(100), scene_, robots_, balls_);
  EXPECT_EQ(take().image.camera, -1);
  EXPECT_EQ(queue->lost(), 0U);
}

TEST_F(Intake, CountsImagesLostToASlowField) {
  const auto queue = intake_.add();
  for (int i = 0; i < 100; ++i) queue->hand_over(info(i), scene_, robots_, balls_);
  EXPECT_GT(queue->lost(), 50U);
  EXPECT_EQ(intake_.lost(), queue->lost());
  EXPECT_EQ(take().image.t_capture_s, 0) << "and what was taken is still there";
}

TEST_F(Intake, StrangersTakeNoPlaceFromOurCameras) {
  const auto ours = intake_.add(), others = intake_.add();
  ArrivedSightings nonsense;
  nonsense.image.camera = 6;
  nonsense.image.t_capture_s = -1e6;
  nonsense.image.is_of_other_computer = true;
  for (int i = 0; i < 10; ++i) {
    for (int packet = 0; packet < 1000; ++packet) others->hand_over(nonsense);
    ours->hand_over(info(i), scene_, robots_, balls_);
  }
  EXPECT_EQ(ours->lost(), 0U);
  int taken = 0;
  for (ArrivedSightings got = take(); got.image.camera != -1; got = take())
    taken += !got.image.is_of_other_computer;
  EXPECT_EQ(taken, 10);
}

TEST_F(Intake, ListsAreLimited) {
  const auto queue = intake_.add();
  robots_.robots.resize(1000, robots_.robots[0]);
  balls_.balls.resize(1000);
  queue->hand_over(info(1), scene_, robots_, balls_);
  const ArrivedSightings got = take();
  EXPECT_EQ(got.image.robots.size(), limits::kMaxRobots);
  EXPECT_EQ(got.image.balls.size(), limits::kMaxFieldBalls);
}

TEST_F(Intake, LeavesOutWhatNoCameraCanSee) {
  const auto queue = intake_.add();
  robots_.robots.push_back(robots_.robots[0]);
  robots_.robots[1].height_mm = 3900;  // 100 mm below the camera
  balls_.balls.push_back({.x_mm = 1,
                          .y_mm = 2,
                          .pixel_x = 0,
                          .pixel_y = 0,
                          .area_px = 60,
                          .confidence = 0.8,
                          .radius_mm = 1e-300,  // an absurdly small ball: its height is unknown
                          .radius_sigma_mm = 0.3});
  queue->hand_over(info(1), scene_, robots_, balls_);
  const ArrivedSightings got = take();
  EXPECT_EQ(got.image.robots.size(), 1U);
  EXPECT_EQ(got.left_out, 1U);
  ASSERT_EQ(got.image.balls.size(), 1U);
  EXPECT_TRUE(std::isinf(got.image.balls[0].height_sigma_mm)) << "nobody knows how high it is";
  balls_.balls[0].radius_mm = std::numeric_limits<double>::infinity();
  queue->hand_over(info(2), scene_, robots_, balls_);
  EXPECT_TRUE(std::isinf(take().image.balls.at(0).height_sigma_mm));
}

TEST_F(Intake, CountsSightingsOfCamerasAtInvalidPositions) {
  const auto queue = intake_.add();
  CameraCalibration calibration = scene_.camera->calibration();
  calibration.tz = 200'000;
  scene_.camera.emplace(calibration);
  balls_.balls.resize(2);
  queue->hand_over(info(1), scene_, robots_, balls_);
  const ArrivedSightings got = take();
  EXPECT_FALSE(got.image.is_taken);
  EXPECT_EQ(got.left_out, 3U);
}

TEST_F(Intake, KeepsTheLossesOfRemovedCameras) {
  auto queue = intake_.add();
  for (int i = 0; i < 100; ++i) queue->hand_over(info(i), scene_, robots_, balls_);
  const std::uint64_t lost = queue->lost();
  queue.reset();
  intake_.drop_unused();
  EXPECT_EQ(intake_.lost(), lost);
  EXPECT_EQ(take().image.camera, -1);
}

}  // namespace
}  // namespace sslv::field_intake_test
