// SPDX-License-Identifier: Apache-2.0
#include "vision/ball_memory.h"

#include <algorithm>
#include <cmath>

namespace sslv {
namespace {

/// Objects outside the lines by less than this may be balls in play.
constexpr double kOffFieldMm = 60;
/// Noise and changes of the light move the fit of a stationary object by less than this.
constexpr double kStillMm = 10;
/// An object that was seen this often at one place is stationary.
constexpr int kStandsAfter = 3;
/// An object that has disappeared elsewhere may have moved here if it was last seen less than kTrackS ago and
/// within kTrackReachMm plus the distance that it can have moved at kFastestMmS.
constexpr double kTrackS = 0.25, kFastestMmS = 8000, kTrackReachMm = 60;
/// A track this long is not caused by detections that flicker between neighbouring objects.
constexpr double kMovedMm = 300;
/// Objects are forgotten if they have not been seen for this time. Objects unlike balls are remembered
/// longer, because they may be hidden for a long time and still be there.
constexpr double kForgetS = 60, kForgetUnlikeS = 3600;

/// A ball that was seen at most this many times at one place may have been rolling past.
constexpr int kPassing = 2;
/// Moved balls nearer to each other than this count once, because they add no information.
constexpr double kOtherPlaceMm = 100;
/// Balls that moved at kEnoughMoved places determine the balls' hue. An object has another hue if
/// the distance of its chromaticity (shares of red, green and blue) from the line between grey and the balls'
/// colour exceeds both kOtherHue and kOtherHueSpreads times the spread of the balls. (In difficult halls
/// drawn by another renderer, this distance is at most 0.03 for balls in 67 of 68 cases and larger for tape
/// in three of four cases.)
constexpr std::size_t kEnoughMoved = 4;
constexpr double kOtherHue = 0.03, kOtherHueSpreads = 4;
/// An object that has been in one place for kStood_s and was seen there kStoodImages times is less round than
/// the balls if its average BallEvidence::out_of_round exceeds the median of balls that moved at
/// kEnoughRound places by both kLessRound and kLessRoundSpreads times their spread. (In the same halls, this
/// holds for tape in 30 of 41 places where it resembles a ball, and for 1.8 % of single images of balls.)
constexpr double kStood_s = 30, kLessRound = 0.6, kLessRoundSpreads = 4;
constexpr std::size_t kEnoughRound = 10;
constexpr int kStoodImages = 10;
/// Number of images over which colour and outline are averaged. Not unlimited, because a ball may come to
/// rest where tape was.
constexpr int kAveraged = 300;
constexpr double kClipped = 250;
/// An object first seen within this time after the first object was there from the beginning.
constexpr double kBeginningS = 10;
/// Limit of the number of images in which an object was seen: more than ten days at 1000 Hz.
constexpr int kMaxCount = 1'000'000'000;

/// Weight of the newest image in an object's confidence over time (its logit). Earlier images do not count
/// for less than kLeastLogit, so that a ball uncovered by a robot is reported at once, nor for more than
/// kMostLogit, so that one that is gone is not reported for long.
constexpr double kNewest = 0.3, kLeastLogit = -1, kMostLogit = 6;

/// Whether colour and outline are possible. Values read from a recording may be any.
template <class Object>
bool is_possible(const Object& object) {
  constexpr double kMaxOutOfRound = 1e6;
  return std::abs(object.out_of_round) <= kMaxOutOfRound &&
         std::ranges::all_of(object.chromaticity, [](double share) { return share >= 0 && share <= 1; });
}

double median_of(std::array<double, 32>& values, std::size_t count) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(count / 2);
  std::nth_element(values.begin(), middle, values.begin() + static_cast<std::ptrdiff_t>(count));
  return *middle;
}

}  // namespace

void BallMemory::begin(double now_s) noexcept {
  if (now_s < now_s_) {
    entries_.clear();
    moved_.clear();
    moved_count_ = 0;
  }
  // An object that was seen in only a few images and is missing in the last image has moved on.
  for (Entry& entry : entries_) {
    if (entry.seen_s < now_s_ && entry.pictures <= kPassing) count_moved(entry);
  }
  const bool knows_nothing = entries_.empty() && moved_.empty();
  if (begun_s_ == 0 || knows_nothing || now_s - now_s_ > kForgetS) begun_s_ = now_s;
  before_s_ = now_s_;
  now_s_ = now_s;
  std::erase_if(moved_, [](const Moved& moved) { return !is_possible(moved); });
  std::erase_if(entries_, [&](const Entry& entry) {
    // A huge count would overflow when it is incremented.
    const auto is_count = [](int count) { return count >= 0 && count < kMaxCount; };
    return now_s - entry.seen_s > (entry.was_unlike ? kForgetUnlikeS : kForgetS) || !is_possible(entry) ||
           !is_count(entry.pictures) || !is_count(entry.colors) || !is_count(entry.outlines);
  });
}

void BallMemory::forget_places() noexcept {
  entries_.clear();
  begun_s_ = 0;
}

void BallMemory::count_moved(Entry& entry) noexcept {
  if (entry.is_counted || !entry.is_sure || entry.colors == 0) return;
  const auto near = std::find_if(moved_.begin(), moved_.end(), [&](const Moved& moved) {
    return std::hypot(moved.x_mm - entry.x_mm, moved.y_mm - entry.y_mm) < kOtherPlaceMm;
  });
  entry.is_counted = true;
  const Moved moved{entry.x_mm, entry.y_mm, entry.chromaticity, entry.out_of_round};
  if (near != moved_.end()) {
    *near = moved;
  } else if (moved_.size() < kMaxMoved) {
    moved_.push_back(moved);
    ++moved_count_;
  } else {
    moved_[moved_count_++ % kMaxMoved] = moved;
  }
}

bool BallMemory::is_unlike_balls(Entry& entry) const noexcept {
  if (!entry.was_there || entry.has_moved || moved_.size() < kEnoughMoved) return false;
  entry.was_unlike = has_other_hue(entry) || is_less_round(entry);
  return entry.was_unlike;
}

bool BallMemory::is_less_round(const Entry& entry) const noexcept {
  const std::size_t count = std::min(moved_.size(), kMaxMoved);
  if (count < kEnoughRound || now_s_ - entry.first_s < kStood_s || entry.outlines < kStoodImages)
    return false;
  std::array<double, kMaxMoved> values;
  for (std::size_t i = 0; i < count; ++i) values[i] = moved_[i].out_of_round;
  const double ball = median_of(values, count);
  for (double& value : values) value = std::abs(value - ball);
  return entry.out_of_round - ball > std::max(kLessRound, kLessRoundSpreads * median_of(values, count));
}

bool BallMemory::has_other_hue(const Entry& entry) const noexcept {
  if (entry.colors == 0) return false;
  const std::size_t count = std::min(moved_.size(), kMaxMoved);
  Color ball{};
  std::array<double, kMaxMoved> values;
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < count; ++i) values[i] = moved_[i].chromaticity[c];
    ball[c] = median_of(values, count);
  }
  // Vector perpendicular to the line from grey to the balls' colour, in the plane of chromaticities (their
  // sum is 1).
  const Color across{ball[1] - ball[2], ball[2] - ball[0], ball[0] - ball[1]};
  const double length = std::hypot(across[0], across[1], across[2]);
  if (!(length > 0)) return false;
  const auto off = [&](const Color& chromaticity) {
    double sum = 0;
    for (std::size_t c = 0; c < 3; ++c) sum += (chromaticity[c] - ball[c]) * across[c];
    return std::abs(sum) / length;
  };
  for (std::size_t i = 0; i < count; ++i) values[i] = off(moved_[i].chromaticity);
  return off(entry.chromaticity) > std::max(kOtherHue, kOtherHueSpreads * median_of(values, count));
}

void BallMemory::average(Entry& entry, const Object& object) noexcept {
  if (std::isfinite(object.out_of_round)) {
    ++entry.outlines;
    entry.out_of_round += (object.out_of_round - entry.out_of_round) / std::min(entry.outlines, kAveraged);
  }
  const Color& color = object.color;
  const double sum = color[0] + color[1] + color[2];
  if (!(sum > 0) || *std::max_element(color.begin(), color.end()) >= kClipped) return;
  ++entry.colors;
  for (std::size_t c = 0; c < 3; ++c)
    entry.chromaticity[c] += (color[c] / sum - entry.chromaticity[c]) / std::min(entry.colors, kAveraged);
}

/// Something that hides a part of an object, or different light, may shift its fit by this much.
bool BallMemory::is_at_first_place(const Entry& entry) noexcept {
  return std::hypot(entry.x_mm - entry.from_x_mm, entry.y_mm - entry.from_y_mm) < kTrackReachMm;
}

std::optional<BallMemory::Known> BallMemory::see_again(const Object& object) noexcept {
  const auto known = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) {
    return std::hypot(entry.x_mm - object.x_mm, entry.y_mm - object.y_mm) < kStillMm;
  });
  if (known == entries_.end()) return {};
  if (known->seen_s < now_s_) {
    ++known->pictures;
    known->velocity_mm_s = {};
    average(*known, object);
  }
  known->seen_s = now_s_;
  known->is_sure = known->is_sure || object.is_sure;
  const bool is_off_field = object.outside_mm > kOffFieldMm;
  return Known{is_off_field && !known->is_ball && known->pictures > kStandsAfter, known->pictures > 1,
               known->pictures > 1 && is_unlike_balls(*known),
               static_cast<std::size_t>(known - entries_.begin())};
}

BallMemory::Known BallMemory::see_elsewhere(const Object& object) noexcept {
  if (const auto known = see_again(object)) return *known;  // with another object of this image
  Entry now{};
  now.x_mm = now.from_x_mm = object.x_mm;
  now.y_mm = now.from_y_mm = object.y_mm;
  now.first_s = now.seen_s = now_s_;
  now.rated_s = now_s_ - kForgetS;
  now.pictures = 1;
  now.is_ball = object.outside_mm <= kOffFieldMm;
  now.is_sure = object.is_sure;
  now.was_there = now_s_ - begun_s_ < kBeginningS;
  bool is_shifted = false;  // only shifted, and there from the beginning
  Entry* before = nullptr;
  double nearest_mm = 0;  // distance from where `before` is expected
  for (Entry& entry : entries_) {
    const double dt = now_s_ - entry.seen_s, dx = object.x_mm - entry.x_mm, dy = object.y_mm - entry.y_mm;
    const double reach_mm = kTrackReachMm + (entry.was_unlike ? 0 : kFastestMmS * dt);
    if (!(dt > 0 && dt < kTrackS) || std::hypot(dx, dy) > reach_mm) continue;
    // A stationary object is assumed to be still at its place.
    if (!entry.is_ball && entry.pictures >= kStandsAfter) continue;
    const auto& [vx, vy] = entry.velocity_mm_s;
    const double here_mm = std::hypot(dx - vx * dt, dy - vy * dt);
    if (before != nullptr && here_mm >= nearest_mm) continue;
    before = &entry;
    nearest_mm = here_mm;
  }
  if (before != nullptr) {
    now.from_x_mm = before->from_x_mm;
    now.from_y_mm = before->from_y_mm;
    now.has_moved =
        before->has_moved || std::hypot(now.x_mm - now.from_x_mm, now.y_mm - now.from_y_mm) > kMovedMm;
    now.is_ball = now.is_ball || before->is_ball || now.has_moved;
    const double dt = now_s_ - before->seen_s;
    now.velocity_mm_s = {(now.x_mm - before->x_mm) / dt, (now.y_mm - before->y_mm) / dt};
    // Within its reach, a ball may have disappeared, and something else appeared.
    if (nearest_mm < kTrackReachMm && before->logit > 0) {
      now.rated_s = before->rated_s;
      now.logit = before->logit;
    }
    is_shifted = before->was_there && is_at_first_place(now);
    if (is_shifted) {
      now.was_there = true;
      now.was_unlike = before->was_unlike;
      now.first_s = before->first_s;
      now.colors = before->colors;
      now.chromaticity = before->chromaticity;
      now.outlines = before->outlines;
      now.out_of_round = before->out_of_round;
    }
    if (now.has_moved) count_moved(*before);
  }
  average(now, object);
  if (before == nullptr && entries_.size() < kMax) {
    entries_.emplace_back();
    before = &entries_.back();
  }
  if (before == nullptr) {
    before = &*std::min_element(entries_.begin(), entries_.end(),
                                [](const Entry& a, const Entry& b) { return a.seen_s < b.seen_s; });
    if (!(before->seen_s < now_s_)) return {};
  }
  *before = now;
  return {.unlike_balls = is_shifted && is_unlike_balls(*before),
          .number = static_cast<std::size_t>(before - entries_.data())};
}

double BallMemory::over_time(std::size_t number, double confidence) noexcept {
  if (number == kNoNumber) return confidence;
  Entry& entry = entries_[number];
  const double logit = std::clamp(std::log(confidence / (1 - confidence)), -30.0, 30.0);
  const bool may_be_fixed = entry.was_there && is_at_first_place(entry);
  double mean = logit;
  if (now_s_ - entry.rated_s < kTrackS) {
    double before = std::clamp(entry.logit, kLeastLogit, kMostLogit);
    if (may_be_fixed && entry.rated_s < before_s_ && before_s_ < now_s_) {
      // In the images since then, it did not even resemble a ball.
      const double images = (now_s_ - entry.rated_s) / (now_s_ - before_s_) - 1;
      before = kLeastLogit + std::pow(1 - kNewest, std::round(images)) * (before - kLeastLogit);
    }
    mean = before + kNewest * (logit - before);
  }
  entry.logit = mean;
  entry.rated_s = now_s_;
  return 1 / (1 + std::exp(-(may_be_fixed ? std::min(mean, logit) : mean)));
}

}  // namespace sslv
