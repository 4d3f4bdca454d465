// SPDX-License-Identifier: Apache-2.0
#include "capture/picture_times.h"

#include <algorithm>
#include <cmath>

namespace sslv {
namespace {

constexpr int kPicturesToTrust = 20;
/// PTP uses TAI, which is ahead of UTC: 37 s in 2026, possibly more later.
constexpr double kMaxLeapS = 45;
/// Limits of the delay from the start of an exposure to the first packet, including errors of the host's
/// clock. The exposure time is added to kLatestS.
constexpr double kEarliestAheadS = -0.001, kLatestS = 0.3;
/// A longer exposure time is an error of the camera.
constexpr double kLongestExposureS = 60;
/// Assumed standard deviation of capture times if both clocks follow the same master.
constexpr double kPtpSigmaS = 20e-6;

}  // namespace

CaptureTimes PictureTimes::of(const PictureStamps& told, double now_s, double steady_s) {
  PictureStamps stamps = told;
  // Treat invalid values as unknown; negated so that NaN is invalid too.
  if (!(stamps.exposure_s >= 0 && stamps.exposure_s <= kLongestExposureS)) stamps.exposure_s = 0;
  CaptureTimes out;
  out.t_capture_camera_s = stamps.camera_s;
  out.t_capture_s = stamps.arrival_s - stamps.exposure_s / 2;
  if (!stamps.camera_s) return out;

  // Update the estimate even with PTP, which may fail later.
  const auto estimate = clock_.add(*stamps.camera_s, stamps.arrival_s - now_s + steady_s);
  double leap_s = 0;
  if (follows_ptp(stamps, leap_s)) {
    out.t_capture_s = *stamps.camera_s - leap_s + stamps.exposure_s / 2;
    out.t_capture_sigma_s = kPtpSigmaS;
    out.is_by_ptp = true;
  } else if (estimate.settled) {
    out.t_capture_s = estimate.t_host_s - steady_s + now_s - stamps.exposure_s / 2;
    out.t_capture_sigma_s = estimate.sigma_s;
  }
  return out;
}

bool PictureTimes::follows_ptp(const PictureStamps& stamps, double& leap_s) {
  if (!stamps.has_ptp) return false;
  const double ahead_s = *stamps.camera_s - stamps.arrival_s;
  leap_s = std::ceil(ahead_s + kEarliestAheadS);
  const double late_s = leap_s - ahead_s;
  const bool agrees = leap_s >= 0 && leap_s <= kMaxLeapS && late_s <= kLatestS + stamps.exposure_s;
  ptp_pictures_ = agrees ? std::min(ptp_pictures_ + 1, kPicturesToTrust) : 0;
  return ptp_pictures_ == kPicturesToTrust;
}

}  // namespace sslv
