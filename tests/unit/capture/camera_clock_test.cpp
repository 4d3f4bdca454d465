// SPDX-License-Identifier: Apache-2.0
#include "capture/camera_clock.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace sslv::camera_clock_test {
namespace {

/// Images of a camera whose clock drifts and steps; they arrive with random delays.
class Simulated {
 public:
  double fps = 60, drift = 0, delay_s = 0.0003;
  double camera_offset_s = 1000;

  /// Simulates `seconds`. Returns the absolute errors in s after the first `settle_s`.
  std::vector<double> run(double seconds, double settle_s) {
    std::vector<double> errors;
    const double end_s = t_s_ + seconds, settled_s = t_s_ + settle_s;
    for (; t_s_ < end_s; t_s_ += 1 / fps) {
      double late_s = std::exponential_distribution<double>(1 / delay_s)(random_);
      if (std::bernoulli_distribution(0.01)(random_)) late_s += 0.005;
      if (std::bernoulli_distribution(0.001)(random_)) late_s += 0.030;
      estimate = clock.add(camera_offset_s + t_s_ * (1 + drift), 500 + t_s_ + late_s);
      if (t_s_ >= settled_s) errors.push_back(std::abs(estimate.t_host_s - (500 + t_s_)));
    }
    return errors;
  }

  CameraClock clock;
  CameraClock::Estimate estimate;

 private:
  double t_s_ = 0;
  std::mt19937 random_{7};
};

double percentile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

TEST(CameraClock, FollowsADriftingClockToAFifthOfAMillisecond) {
  for (const double fps : {20.0, 60.0, 200.0}) {
    for (const double drift : {-100e-6, 0.0, 100e-6}) {
      Simulated camera;
      camera.fps = fps;
      camera.drift = drift;
      EXPECT_LT(percentile(camera.run(60, 5), 0.99), 0.0002) << fps << " " << drift;
      EXPECT_NEAR(camera.clock.drift(), drift, 15e-6);
      EXPECT_TRUE(camera.estimate.settled);
    }
  }
}

TEST(CameraClock, RelearnsWhenTheCamerasClockSteps) {
  Simulated camera;
  camera.drift = 100e-6;
  camera.run(20, 0);
  for (const double step_s : {0.5, -0.02, -1400.0, 3600.0}) {
    camera.camera_offset_s += step_s;
    EXPECT_LT(percentile(camera.run(30, 5), 0.99), 0.0002) << step_s;
  }
}

TEST(CameraClock, ABrieflyBusyHostIsNoStep) {
  CameraClock clock;
  for (int i = 0; i < 600; ++i) clock.add(i / 60.0, 10 + i / 60.0);
  CameraClock::Estimate estimate;
  for (int i = 600; i < 612; ++i) estimate = clock.add(i / 60.0, 10 + i / 60.0 + 0.050);
  EXPECT_NEAR(estimate.t_host_s, 10 + 611 / 60.0, 1e-6);
}

TEST(CameraClock, SaysHowSureItIs) {
  Simulated exact, shaky;
  exact.delay_s = 20e-6;
  shaky.delay_s = 1e-3;
  const double exact_error = percentile(exact.run(30, 5), 0.5),
               shaky_error = percentile(shaky.run(30, 5), 0.5);
  EXPECT_LT(exact.estimate.sigma_s, 50e-6);
  EXPECT_GT(shaky.estimate.sigma_s, 100e-6);
  EXPECT_LT(exact_error, 3 * exact.estimate.sigma_s);
  EXPECT_LT(shaky_error, 3 * shaky.estimate.sigma_s);
}

TEST(CameraClock, FromTheFirstPictureOn) {
  CameraClock clock;
  const auto first = clock.add(77, 1234.5);
  EXPECT_DOUBLE_EQ(first.t_host_s, 1234.5);
  EXPECT_FALSE(first.settled);
  // The second image arrived with less delay than the first.
  EXPECT_NEAR(clock.add(77.5, 1234.9).t_host_s, 1234.9, 1e-9);
}

}  // namespace
}  // namespace sslv::camera_clock_test
