// SPDX-License-Identifier: Apache-2.0
#include "capture/v4l2/v4l2_times.h"

#include <cmath>

#include <linux/videodev2.h>

namespace sslv {
namespace {

/// Standard deviation of a kernel time stamp: USB delivers up to 4 ms of data at once, so the error is
/// uniform.
constexpr double kStampSigmaS = 0.0012;
/// Frame period that is assumed if the device does not report it.
constexpr double kUsualPeriodS = 1.0 / 30;

/// Standard deviation of a uniform distribution of this width.
double spread_s(double width_s) {
  return width_s / std::sqrt(12.0);
}

}  // namespace

CaptureTimes capture_times(double stamp_s, const V4l2Timing& timing) {
  CaptureTimes times;
  times.t_capture_s = stamp_s;
  if (timing.stamped_at == V4l2StampedAt::kArrival) return times;
  const double period_s = timing.period_s > 0 ? timing.period_s : kUsualPeriodS;
  // An unknown exposure is assumed uniform between 0 and the period.
  const double half_exposure_s = timing.exposure_s.value_or(period_s / 2) / 2;
  double sigma_s = kStampSigmaS;
  if (!timing.exposure_s) sigma_s = std::hypot(sigma_s, spread_s(period_s / 2));
  // The duration of the transfer, which begins at the end of the exposure, is also assumed uniform.
  if (timing.stamped_at == V4l2StampedAt::kPictureEnd) {
    times.t_capture_s -= period_s / 2;
    sigma_s = std::hypot(sigma_s, spread_s(period_s));
  }
  times.t_capture_s +=
      timing.stamped_at == V4l2StampedAt::kExposureStart ? half_exposure_s : -half_exposure_s;
  times.t_capture_sigma_s = sigma_s;
  return times;
}

V4l2StampedAt stamped_at(std::uint32_t buffer_flags, bool stamps_first_bytes) {
  if ((buffer_flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) != V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC)
    return V4l2StampedAt::kArrival;
  if (stamps_first_bytes) return V4l2StampedAt::kExposureEnd;
  return (buffer_flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE
             ? V4l2StampedAt::kExposureStart
             : V4l2StampedAt::kPictureEnd;
}

}  // namespace sslv
