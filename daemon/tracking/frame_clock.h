// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sslv {

/// When a camera's images were really taken. A camera takes them at an even rate, but their time stamps
/// jitter: by .2 ms, a robot at 4 m/s moves ten times as far as its place is uncertain. So the clock follows
/// the stamps slowly.
class FrameClock {
 public:
  /// The time of an image, from its stamp. Starts again where stamps jump or stop.
  double time_of(double t_capture_s) noexcept;
  /// How much stamps differ from the even rate (rms).
  double jitter_s() const noexcept { return jitter_s_; }
  /// How sure its times are.
  double sigma_s() const noexcept;

 private:
  void start(double t_capture_s) noexcept;

  int images_ = 0;
  double t_s_ = 0, stamp_s_ = 0, period_s_ = 0;
  double jitter_s_ = 0, drift_s_ = 0;  // means of the last stamps' differences, without and with their signs
};

}  // namespace sslv
