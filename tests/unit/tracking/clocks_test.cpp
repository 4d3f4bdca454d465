// SPDX-License-Identifier: Apache-2.0
#include "tracking/clocks.h"

#include "halls/chance.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace sslv::clocks_test {
namespace {

constexpr double kPeriod_s = 0.015;

struct Camera {
  double uneven_s, jitter_s;  // of the true times; of the time stamps
};

/// Plays six robots for 20 s; returns the rms error of the times in the second half (s), without their mean.
double error_s(const Camera& camera, Clocks& clocks, ImageTime& last) {
  halls::Chance chance(7, "clocks");
  double sum = 0, squares = 0;
  int count = 0;
  constexpr int kImages = 1400;
  for (int i = 0; i < kImages; ++i) {
    const double t_s = 1e9 + i * kPeriod_s +
                       std::clamp(camera.uneven_s * chance.normal(), -0.4 * kPeriod_s, 0.4 * kPeriod_s);
    CameraSightings seen;
    seen.t_capture_s = t_s + camera.jitter_s * chance.normal();
    for (int id = 0; id < 6; ++id) {
      RobotSighting robot{};
      robot.team = Team::kBlue;
      robot.id = id;
      const double phase = 0.7 * (t_s - 1e9) + id;
      robot.place_mm = {2000 * std::sin(phase) + chance.normal(), 1500 * std::cos(phase) + chance.normal()};
      robot.place_cov_mm2 = Eigen::Matrix2d::Identity();
      seen.robots.push_back(robot);
    }
    clocks.process({}, seen, last);
    if (i < kImages / 2) continue;
    const double off_s = *last.t_s - t_s;
    sum += off_s;
    squares += off_s * off_s;
    ++count;
  }
  return std::sqrt(std::max(0.0, squares / count - std::pow(sum / count, 2)));
}

TEST(Clocks, EvenOutTheStampsOfACameraWithAConstantRate) {
  Clocks clocks;
  ImageTime last;
  EXPECT_LT(error_s({0, 0.3e-3}, clocks, last), 0.12e-3);
  EXPECT_GT(last.evenness, 0.8);
}

TEST(Clocks, TakeTheStampsOfUnevenImagesAsTheyAre) {
  Clocks clocks;
  ImageTime last;
  EXPECT_LT(error_s({2e-3, 0}, clocks, last), 0.2e-3);
  EXPECT_LT(last.evenness, 0.1);
}

TEST(Clocks, EvenOutLargeJitterOnceRobotsConfirmIt) {
  Clocks clocks;
  ImageTime last;
  EXPECT_LT(error_s({0, 1e-3}, clocks, last), 0.5e-3);
  EXPECT_GT(last.evenness, 0.9);
}

TEST(Clocks, ForgetTheCameraThatIsSilentForLongest) {
  Clocks clocks;
  ImageTime time;
  error_s({2e-3, 0}, clocks, time);
  double t_s = 1e9 + 30;
  const auto see = [&](int camera) {
    CameraSightings seen;
    seen.camera = camera;
    seen.t_capture_s = t_s += 1e-3;
    clocks.process({}, seen, time);
    return time.evenness;
  };
  const double learnt = see(0);
  EXPECT_LT(learnt, 0.5);
  for (int id = 100; id < 200; ++id) {
    see(id);
    ASSERT_LT(see(0), 0.5) << "it still sends";
  }
  for (int id = 200; id < 300; ++id) see(id);
  EXPECT_GT(see(0), 0.5) << "it is new again";
}

TEST(Clocks, KnowHowUncertainTheyAre) {
  for (const Camera& camera : {Camera{0, 0.3e-3}, Camera{2e-3, 0}, Camera{1e-3, 0.5e-3}}) {
    Clocks clocks;
    ImageTime last;
    const double off_s = error_s(camera, clocks, last);
    EXPECT_LT(off_s, 3 * last.sigma_s) << camera.uneven_s;
    EXPECT_GT(off_s, last.sigma_s / 4) << camera.uneven_s;
  }
}

}  // namespace
}  // namespace sslv::clocks_test
