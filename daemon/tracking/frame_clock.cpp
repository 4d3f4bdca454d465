// SPDX-License-Identifier: Apache-2.0
#include "tracking/frame_clock.h"

#include <algorithm>
#include <cmath>

namespace sslv {

void FrameClock::start(double t_capture_s) noexcept {
  *this = {};
  images_ = 1;
  t_s_ = stamp_s_ = t_capture_s;
}

double FrameClock::time_of(double t_capture_s) noexcept {
  constexpr double kGap_s = 0.5;
  const double passed_s = t_capture_s - stamp_s_;
  if (images_ == 0 || passed_s <= 0 || passed_s > kGap_s) {
    start(t_capture_s);
    return t_s_;
  }
  stamp_s_ = t_capture_s;
  ++images_;
  if (images_ == 2) {
    period_s_ = passed_s;
    t_s_ = t_capture_s;
    return t_s_;
  }
  // If more than a period has passed, images are missing, regardless of their numbers.
  double periods = std::max(1.0, std::round((t_capture_s - t_s_) / period_s_));
  double expected_s = t_s_ + periods * period_s_;
  double off_s = t_capture_s - expected_s;
  if (images_ < 6 && passed_s < 0.7 * period_s_) {  // the first two images were not consecutive
    period_s_ = passed_s;
    t_s_ = t_capture_s;
    images_ = 2;
    return t_s_;
  }
  // The rate changed, or a clock was set.
  constexpr double kMaxOff = 0.35, kSame = 0.97;
  if (std::abs(off_s) > kMaxOff * period_s_) {
    start(t_capture_s);
    return t_s_;
  }
  drift_s_ = kSame * drift_s_ + (1 - kSame) * off_s;
  jitter_s_ = std::sqrt(kSame * jitter_s_ * jitter_s_ + (1 - kSame) * off_s * off_s);
  // Deviations of one sign mean that the rate has changed a little: estimate it again.
  constexpr int kSettled = 60;
  if (images_ > kSettled && std::abs(drift_s_) > 0.7 * jitter_s_ + 1e-5) images_ = 8;
  // At first, these are the gains of a straight line fitted to all time stamps.
  const double count = images_;
  const double follow = std::max(0.03, 2 * (2 * count - 1) / (count * (count + 1)));
  const double rate = std::max(0.0004, 6 / (count * (count + 1)));
  t_s_ = expected_s + follow * off_s;
  period_s_ += rate * off_s / periods;
  return t_s_;
}

double FrameClock::sigma_s() const noexcept {
  constexpr double kSettles = 0.12;  // share of the jitter that remains once settled
  return std::max(kLeastSigma_s, kSettles * jitter_s_);
}

}  // namespace sslv
