// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sslv {

/// Estimates the true capture times of a camera's images. A camera takes images at a constant rate, but their
/// time stamps jitter: in 0.2 ms, a robot at 4 m/s moves by ten times the uncertainty of its position. So the
/// clock follows the stamps slowly.
class FrameClock {
 public:
  /// Estimated capture time of the image with this time stamp. Restarts when stamps jump or pause.
  double time_of(double t_capture_s) noexcept;
  /// Deviation of the stamps from the constant rate (rms, s).
  double jitter_s() const noexcept { return jitter_s_; }
  /// Smallest sigma of any time (s).
  static constexpr double kLeastSigma_s = 0.02e-3;
  /// Sigma of the estimated times (s).
  double sigma_s() const noexcept;

 private:
  void start(double t_capture_s) noexcept;

  int images_ = 0;
  double t_s_ = 0, stamp_s_ = 0, period_s_ = 0;
  double jitter_s_ = 0, drift_s_ = 0;  // rms and mean of the last stamps' deviations
};

}  // namespace sslv
