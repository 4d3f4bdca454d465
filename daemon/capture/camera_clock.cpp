// SPDX-License-Identifier: Apache-2.0
#include "capture/camera_clock.h"

#include <algorithm>
#include <cmath>

namespace sslv {
namespace {

constexpr double kBinS = 0.25, kLongestBinS = 1;
constexpr std::size_t kMinInBin = 10;
/// The quantile is low enough to exclude delays and high enough to be robust.
constexpr double kQuantile = 0.2;
constexpr std::size_t kBinsForDrift = 5;
/// Repeated deviations beyond these limits count as a clock jump. A few early images are enough, because an
/// image cannot arrive early. Late images must persist for kLateForS, because a busy host may also cause
/// them.
constexpr double kJumpS = 0.003, kJumpSpreadS = 0.010, kLateForS = 0.5;
constexpr int kEarlyPictures = 3, kLatePictures = 8;
/// A camera that was silent for this long may have been switched off and on.
constexpr double kGapS = 10;

double quantile(const double* sorted, std::size_t count) {
  return sorted[static_cast<std::size_t>(kQuantile * static_cast<double>(count - 1) + 0.5)];
}

}  // namespace

CameraClock::Estimate CameraClock::add(double t_camera_s, double t_arrival_s) {
  const double t_s = t_camera_s - base_camera_s_;
  if (!started_ || t_s < last_s_ || t_s > last_s_ + kGapS ||
      has_jumped(t_s, t_arrival_s - base_arrival_s_ - t_s)) {
    restart();
    started_ = true;
    base_camera_s_ = t_camera_s;
    base_arrival_s_ = t_arrival_s;
    return add(t_camera_s, t_arrival_s);
  }
  last_s_ = t_s;
  const double offset_s = t_arrival_s - base_arrival_s_ - t_s;
  if (strays_.count == 0) {
    const double age_s = t_s - bin_.start_s;
    const bool full = bin_.count == kMaxInBin || (age_s >= kBinS && bin_.count >= kMinInBin);
    if (bin_.count > 0 && (full || age_s >= kLongestBinS)) close_bin();
    if (bin_.count == 0) bin_.start_s = t_s;
    const auto end = bin_.offsets_s.begin() + static_cast<std::ptrdiff_t>(bin_.count);
    const auto place = std::upper_bound(bin_.offsets_s.begin(), end, offset_s);
    std::copy_backward(place, end, end + 1);
    *place = offset_s;
    ++bin_.count;
    bin_.t_sum_s += t_s;
    if (bins_.count == 0) {
      line_.offset_s = quantile(bin_.offsets_s.data(), bin_.count);
      residual_s_ = bin_.offsets_s[bin_.count - 1] - bin_.offsets_s[0];
      rise_s_ = line_.offset_s - bin_.offsets_s[0];
    }
  }
  Estimate out;
  out.t_host_s = base_arrival_s_ + t_s + line_.at(t_s);
  out.settled = bins_.count >= kBinsForDrift;
  // A fitted line is twice as uncertain at its end as in its middle. The height of the quantile above an
  // image without delay is unknown, so the quantile's mean height above the earliest image of each bin counts
  // as uncertainty.
  out.sigma_s = std::hypot(
      2 * residual_s_ / std::sqrt(static_cast<double>(std::max<std::size_t>(1, bins_.count))), rise_s_);
  return out;
}

bool CameraClock::has_jumped(double t_s, double offset_s) {
  if (bins_.count == 0) return false;
  const double off_s = offset_s - line_.at(t_s);
  const double spread_s = std::max(kJumpS, 6 * residual_s_);
  const bool early = off_s<-spread_s, late = off_s> std::max(kJumpSpreadS, spread_s);
  const bool goes_on = strays_.count > 0 && std::abs(off_s - strays_.offset_s) < kJumpSpreadS;
  if (!early && !late) {
    strays_.count = 0;
    return false;
  }
  if (!goes_on) {
    strays_.count = 0;
    strays_.offset_s = off_s;
    strays_.first_s = t_s;
  }
  ++strays_.count;
  return early ? strays_.count >= kEarlyPictures
               : strays_.count >= kLatePictures && t_s - strays_.first_s >= kLateForS;
}

void CameraClock::restart() {
  *this = CameraClock{};
}

void CameraClock::close_bin() {
  const auto count = static_cast<double>(bin_.count);
  const double low_s = quantile(bin_.offsets_s.data(), bin_.count);
  bins_.points[bins_.next] = {bin_.t_sum_s / count, low_s, low_s - bin_.offsets_s[0]};
  bins_.next = (bins_.next + 1) % kBins;
  bins_.count = std::min(bins_.count + 1, kBins);
  bin_.count = 0;
  bin_.t_sum_s = 0;
  fit();
}

/// Least squares with Huber weights: points far from the previous line count less.
void CameraClock::fit() {
  constexpr int kRounds = 4;
  constexpr double kMinSpreadS = 2e-6;
  double spread_s = 0;
  for (int round = 0; round < kRounds; ++round) {
    double weights = 0, t_sum = 0, offset_sum = 0;
    const auto weight_of = [&](const Point& point) {
      const double off_s = std::abs(point.offset_s - line_.at(point.t_s));
      return spread_s > 0 && off_s > 1.5 * spread_s ? 1.5 * spread_s / off_s : 1;
    };
    std::array<double, kBins> weight{};
    for (std::size_t i = 0; i < bins_.count; ++i) {
      weight[i] = weight_of(bins_.points[i]);
      weights += weight[i];
      t_sum += weight[i] * bins_.points[i].t_s;
      offset_sum += weight[i] * bins_.points[i].offset_s;
    }
    line_.middle_s = t_sum / weights;
    line_.offset_s = offset_sum / weights;
    double tt = 0, to = 0;
    for (std::size_t i = 0; i < bins_.count; ++i) {
      const double t_s = bins_.points[i].t_s - line_.middle_s;
      tt += weight[i] * t_s * t_s;
      to += weight[i] * t_s * (bins_.points[i].offset_s - line_.offset_s);
    }
    line_.slope = bins_.count >= kBinsForDrift && tt > 0 ? to / tt : 0;
    std::array<double, kBins> off_s{};
    for (std::size_t i = 0; i < bins_.count; ++i)
      off_s[i] = std::abs(bins_.points[i].offset_s - line_.at(bins_.points[i].t_s));
    const auto middle = off_s.begin() + static_cast<std::ptrdiff_t>(bins_.count / 2);
    std::nth_element(off_s.begin(), middle, off_s.begin() + static_cast<std::ptrdiff_t>(bins_.count));
    spread_s = std::max(kMinSpreadS, *middle / 0.6745);
  }
  residual_s_ = spread_s;
  rise_s_ = 0;
  for (std::size_t i = 0; i < bins_.count; ++i)
    rise_s_ += bins_.points[i].rise_s / static_cast<double>(bins_.count);
}

}  // namespace sslv
