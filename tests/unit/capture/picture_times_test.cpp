// SPDX-License-Identifier: Apache-2.0
#include "capture/picture_times.h"

#include <limits>

#include <gtest/gtest.h>

namespace sslv::picture_times_test {
namespace {

constexpr double kNowS = 1.8e9, kSteadyS = 5000;

/// Images taken 0.01 s apart that arrive `late_s` after the start of their exposure.
struct Camera {
  double clock_ahead_s = 0, late_s = 0.005;
  PictureStamps stamps{0, 0.0, 0.004, true};
  PictureTimes times;
  int taken = 0;

  /// Takes `count` more images. Returns the error in s of the last one's time; `now` has its times.
  double error_s(int count) {
    double error = 0;
    for (int i = 0; i < count; ++i) {
      const double begin_s = kNowS + 0.01 * ++taken;
      stamps.camera_s = begin_s + clock_ahead_s;
      stamps.arrival_s = begin_s + late_s;
      now = times.of(stamps, stamps.arrival_s + 0.001, kSteadyS + 0.01 * taken + late_s + 0.001);
      error = now.t_capture_s - (begin_s + stamps.exposure_s / 2);
    }
    return error;
  }
  CaptureTimes now{};
};

constexpr double kRounding = 2e-6;  // s; of several Unix times in doubles

TEST(PictureTimes, UnderPtpTheCamerasClockIsTheHosts) {
  for (const double ahead_s : {0.0, 37.0}) {  // in UTC or in TAI
    Camera camera;
    camera.clock_ahead_s = ahead_s;
    EXPECT_NEAR(camera.error_s(30), 0, kRounding);
    EXPECT_TRUE(camera.now.is_by_ptp);
    EXPECT_LT(*camera.now.t_capture_sigma_s, 1e-3);
    // However late an image arrives.
    camera.late_s = 0.2;
    EXPECT_NEAR(camera.error_s(1), 0, kRounding);
    EXPECT_TRUE(camera.now.is_by_ptp);
  }
}

TEST(PictureTimes, ClocksThatDisagreeAreNotSynchronised) {
  for (const double ahead_s : {-1.0, 0.3, 36.6, -5.4e8, 1e6}) {
    Camera camera;
    camera.clock_ahead_s = ahead_s;
    camera.error_s(1000);
    EXPECT_FALSE(camera.now.is_by_ptp) << ahead_s;
    EXPECT_TRUE(camera.now.t_capture_sigma_s);  // from the estimated clock offset
  }
}

TEST(PictureTimes, WithoutPtpAgreementIsIgnored) {
  Camera camera;
  camera.stamps.has_ptp = false;
  camera.error_s(1000);
  EXPECT_FALSE(camera.now.is_by_ptp);
}

TEST(PictureTimes, ACameraThatLosesItsPtpMasterIsEstimated) {
  Camera camera;
  camera.error_s(1000);
  ASSERT_TRUE(camera.now.is_by_ptp);
  camera.clock_ahead_s = -0.5;
  camera.error_s(1);
  EXPECT_FALSE(camera.now.is_by_ptp);
  // Only the arrival is known then: 1 ms after the end of the exposure.
  EXPECT_NEAR(camera.error_s(3000), 0.005 - 0.004, 1e-4);
}

TEST(PictureTimes, InvalidExposuresAreIgnored) {
  constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
  for (const double exposure_s : {kNoNumber, -1.0, 1e9, std::numeric_limits<double>::infinity()}) {
    PictureTimes times;
    EXPECT_EQ(times.of({kNowS, {}, exposure_s, false}, kNowS, kSteadyS).t_capture_s, kNowS) << exposure_s;
  }
}

TEST(PictureTimes, FromItsArrivalAtTheBeginning) {
  Camera camera;
  camera.stamps.has_ptp = false;
  EXPECT_NEAR(camera.error_s(1), 0.005 - 0.004, kRounding);
  EXPECT_FALSE(camera.now.t_capture_sigma_s);
  PictureStamps without_clock;
  without_clock.arrival_s = 100;
  without_clock.exposure_s = 0.02;
  const CaptureTimes times = PictureTimes{}.of(without_clock, 100, 1);
  EXPECT_DOUBLE_EQ(times.t_capture_s, 99.99);
  EXPECT_FALSE(times.t_capture_camera_s);
}

}  // namespace
}  // namespace sslv::picture_times_test
