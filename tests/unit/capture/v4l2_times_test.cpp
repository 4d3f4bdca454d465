// SPDX-License-Identifier: Apache-2.0
#include "capture/v4l2/v4l2_times.h"

#include <cmath>

#include <gmock/gmock.h>
#include <linux/videodev2.h>

namespace sslv::v4l2_times_test {
namespace {

constexpr double kJitter = 0.0012;

TEST(V4l2Times, ArrivalSaysNothingOfTheExposure) {
  const CaptureTimes times = capture_times(100, {V4l2StampedAt::kArrival, 0.02, 0.1});
  EXPECT_EQ(times.t_capture_s, 100);
  EXPECT_FALSE(times.t_capture_sigma_s);
}

TEST(V4l2Times, AKnownExposureGivesItsMiddle) {
  EXPECT_DOUBLE_EQ(capture_times(100, {V4l2StampedAt::kExposureStart, 0.02, 0.1}).t_capture_s, 100.01);
  EXPECT_DOUBLE_EQ(capture_times(100, {V4l2StampedAt::kExposureEnd, 0.02, 0.1}).t_capture_s, 99.99);
  EXPECT_DOUBLE_EQ(*capture_times(100, {V4l2StampedAt::kExposureEnd, 0.02, 0.1}).t_capture_sigma_s, kJitter);
}

TEST(V4l2Times, AnUnknownExposureLastsUpToTheWholePeriod) {
  const CaptureTimes times = capture_times(100, {V4l2StampedAt::kExposureEnd, std::nullopt, 0.1});
  EXPECT_DOUBLE_EQ(times.t_capture_s, 100 - 0.025);
  EXPECT_DOUBLE_EQ(*times.t_capture_sigma_s, std::hypot(kJitter, 0.05 / std::sqrt(12)));
}

TEST(V4l2Times, ATransferLastsUpToTheWholePeriod) {
  const CaptureTimes times = capture_times(100, {V4l2StampedAt::kPictureEnd, 0.02, 0.1});
  EXPECT_DOUBLE_EQ(times.t_capture_s, 100 - 0.05 - 0.01);
  EXPECT_DOUBLE_EQ(*times.t_capture_sigma_s, std::hypot(kJitter, 0.1 / std::sqrt(12)));
}

TEST(V4l2Times, FlagsDefineTheTimestamp) {
  constexpr std::uint32_t kMonotonic = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  EXPECT_EQ(stamped_at(0, false), V4l2StampedAt::kArrival);
  EXPECT_EQ(stamped_at(V4L2_BUF_FLAG_TIMESTAMP_COPY, false), V4l2StampedAt::kArrival);
  EXPECT_EQ(stamped_at(kMonotonic | V4L2_BUF_FLAG_TSTAMP_SRC_EOF, false), V4l2StampedAt::kPictureEnd);
  EXPECT_EQ(stamped_at(kMonotonic | V4L2_BUF_FLAG_TSTAMP_SRC_SOE, false), V4l2StampedAt::kExposureStart);
  EXPECT_EQ(stamped_at(kMonotonic | V4L2_BUF_FLAG_TSTAMP_SRC_SOE, true), V4l2StampedAt::kExposureEnd);
}

}  // namespace
}  // namespace sslv::v4l2_times_test
