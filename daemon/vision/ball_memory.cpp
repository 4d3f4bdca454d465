// SPDX-License-Identifier: Apache-2.0
#include "vision/ball_memory.h"

#include <algorithm>
#include <cmath>

namespace sslv {
namespace {

/// What is nearer to the lines may be a ball in play.
constexpr double kOffFieldMm = 60;
/// Noise and light move a fit less far.
constexpr double kStillMm = 10;
/// Seen so often at one place, a thing stands there.
constexpr int kStandsAfter = 3;
/// What was seen within this time, at most so far away and is gone may have moved here.
constexpr double kTrackS = 0.25, kFastestMmS = 8000, kTrackReachMm = 60;
/// A track so long is no flickering of things side by side.
constexpr double kMovedMm = 300;
constexpr double kForgetS = 60;

}  // namespace

void BallMemory::begin(double now_s) noexcept {
  if (now_s < now_s_) count_ = 0;
  now_s_ = now_s;
  const auto end = std::remove_if(entries_.begin(), entries_.begin() + count_,
                                  [&](const Entry& entry) { return now_s - entry.seen_s > kForgetS; });
  count_ = static_cast<std::size_t>(end - entries_.begin());
}

BallMemory::Known BallMemory::see(double x_mm, double y_mm, double outside_mm) noexcept {
  const auto begin = entries_.begin(), end = begin + count_;
  const auto distance_mm = [&](const Entry& entry) {
    return std::hypot(entry.x_mm - x_mm, entry.y_mm - y_mm);
  };
  const auto known =
      std::find_if(begin, end, [&](const Entry& entry) { return distance_mm(entry) < kStillMm; });
  const bool is_off_field = outside_mm > kOffFieldMm;
  if (known != end) {
    if (known->seen_s < now_s_) ++known->pictures;
    known->seen_s = now_s_;
    return {is_off_field && !known->is_ball && known->pictures > kStandsAfter, known->pictures > 1};
  }
  Entry now{x_mm, y_mm, x_mm, y_mm, now_s_, now_s_, 1, !is_off_field};
  Entry* before = nullptr;
  for (auto entry = begin; entry != end; ++entry) {
    const double dt = now_s_ - entry->seen_s;
    if (!(dt > 0 && dt < kTrackS) || distance_mm(*entry) > kTrackReachMm + kFastestMmS * dt) continue;
    // What stood there for long stands there still.
    if (!entry->is_ball && entry->pictures >= kStandsAfter) continue;
    if (before == nullptr || distance_mm(*entry) < distance_mm(*before)) before = &*entry;
  }
  if (before != nullptr) {
    now.from_x_mm = before->from_x_mm;
    now.from_y_mm = before->from_y_mm;
    now.is_ball =
        now.is_ball || before->is_ball || std::hypot(x_mm - now.from_x_mm, y_mm - now.from_y_mm) > kMovedMm;
    *before = now;
  } else if (count_ < kMost) {
    entries_[count_++] = now;
  } else {
    *std::min_element(begin, end, [](const Entry& a, const Entry& b) { return a.seen_s < b.seen_s; }) = now;
  }
  return {};
}

}  // namespace sslv
