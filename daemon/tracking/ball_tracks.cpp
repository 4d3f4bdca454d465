// SPDX-License-Identifier: Apache-2.0
#include "tracking/ball_tracks.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sslv {

using Eigen::Vector2d;

namespace {

constexpr std::size_t kMost = 6;
/// Measurements after which a track counts as established.
constexpr int kOld = 8;
constexpr double kLately_s = 0.03;

bool lies(const BallTrack& track, double t_s) {
  constexpr double kLies_s = 0.05;
  return t_s - track.moved_s() > kLies_s;
}

}  // namespace

BallTracks::BallTracks() {
  // Upper limits before pruning, so that processing an image allocates nothing.
  constexpr std::size_t kSeen = 32;
  balls_.reserve(2 * kMost + kSeen);
  unexplained_.reserve(kSeen);
  own_.reserve(kSeen);
  seen_.reserve(kSeen);
}

bool BallTracks::is_sure(const BallTrack& track, double t_s, bool is_in_doubt) {
  // Short-lived clutter does not move, so a stationary track needs more measurements. A hand moves, but not
  // steadily.
  const int enough = lies(track, t_s) ? 6 : 3;
  return track.is_steady() && track.sightings() >= (is_in_doubt ? 2 * enough + 2 : enough);
}

/// Whether one ball can have moved between the last measurements of the two tracks.
bool BallTracks::reaches(const BallTrack& one, const BallTrack& other) {
  constexpr double kFastest_mm_s = 8000, kNearMm = 300;
  const double passed_s = std::abs(other.seen_s() - one.seen_s());
  return (other.seen_mm() - one.seen_mm()).norm() < kFastest_mm_s * passed_s + kNearMm;
}

/// Whether a measurement belongs to another, established track, so that it is not evidence for a turn of
/// `ball`.
bool BallTracks::is_of_another(const BallObservation& one, const Ball& ball,
                               const RobotTracks& robots) const {
  if (ball.is_past || balls_.size() < 2) return false;
  int is_own = -1;  // -1: not evaluated yet
  for (const Ball& other : balls_) {
    if (&other == &ball || other.is_past || other.track.sightings() < kOld) continue;
    if (!other.track.explains(one, robots)) continue;
    if (other.track.sightings() > ball.track.sightings()) return true;
    if (is_own < 0) is_own = ball.track.explains(one, robots);
    if (is_own == 0) return true;
  }
  return false;
}

void BallTracks::set_model(const BallModel& model) {
  model_ = model;
  for (Ball& ball : balls_) ball.track.set_model(model);
}

void BallTracks::add(const std::vector<BallObservation>& all, const RobotTracks& robots) {
  if (all.empty()) return;
  std::vector<BallObservation>& seen = seen_;
  seen = all;
  for (BallObservation& one : seen) one.is_over_robot = robots.is_over_robot(one, model_.radius_mm);
  const double now_s = seen.front().t_s;
  const std::size_t count = balls_.size();  // excludes tracks added in this loop
  for (std::size_t i = 0; i < count; ++i) {
    own_.clear();
    for (const BallObservation& one : seen) {
      if (one.is_over_robot && !balls_[i].track.is_in_the_air(now_s)) continue;
      if (!is_of_another(one, balls_[i], robots)) own_.push_back(one);
    }
    if (balls_[i].track.add(own_, robots, before_) != BallTrack::Saw::kTurn) continue;
    Ball& ball = balls_[i];
    // While balls_[0] is still seen, the hypothesis from before its turn must not turn as well.
    if (ball.is_past && now_s - balls_[0].track.seen_s() < kLately_s) {
      ball.track = *before_;
      continue;
    }
    const Ball past{*before_, ball.number, true, ball.began_s};
    ball.is_past = false;
    balls_.push_back(past);
  }
  look_for_balls(seen, robots);
  choose_ball(now_s, robots);
  take_kick();
}

void BallTracks::find_played(double t_s) {
  constexpr double kForgotten_s = 3;
  for (std::size_t i = 0; i < balls_.size() && !is_known_; ++i) {
    const Ball& ball = balls_[i];
    if (t_s - ball.track.seen_s() > kLately_s || !is_sure(ball.track, t_s, false)) continue;
    // A ball that was stationary while another ball was in play is not the hidden ball in play.
    if (lies(ball.track, t_s) && ball.began_s < lost_s_ && t_s - lost_s_ < kForgotten_s) continue;
    is_known_ = true;
    std::swap(balls_[0], balls_[i]);
  }
}

void BallTracks::choose_ball(double t_s, const RobotTracks& robots) {
  // A track whose filter is not finite is dropped; the next measurements start a new one.
  const auto broken = std::ranges::count_if(balls_, [](const Ball& ball) { return !ball.track.is_finite(); });
  repaired_ += static_cast<std::uint64_t>(broken);
  const auto ends = [&](const Ball& ball) {
    return ball.track.is_gone(t_s) || ball.track.is_too_fast() || (broken > 0 && !ball.track.is_finite());
  };
  if (is_known_ && ends(balls_[0])) {
    is_known_ = false;
    lost_s_ = balls_[0].track.is_finite() ? balls_[0].track.seen_s() : t_s;
  }
  std::erase_if(balls_, ends);
  if (!is_known_) find_played(t_s);
  if (!is_known_) return;
  constexpr double kUnseen_s = 0.05, kLost_s = 0.4, kStill_s = 1;
  constexpr int kPlayed = 20;
  // A turn was wrong if the ball of the earlier hypothesis is seen again and the turned ball is not.
  std::size_t first = 0;
  for (std::size_t i = 1; i < balls_.size(); ++i) {
    const BallTrack &shown = balls_[first].track, &other = balls_[i].track;
    if (t_s - other.seen_s() > kLately_s) continue;
    const double unseen_s = other.seen_s() - shown.seen_s();
    // Somebody put the ball elsewhere: it appears there when it disappears here.
    constexpr double kAtOnce_s = 0.25, kOverlap_s = 0.02, kUsual_s = 0.08, kStays_s = 0.04;
    constexpr int kSteady = 5;
    const double appeared_s = balls_[i].began_s - shown.seen_s();
    if (!balls_[i].is_past && appeared_s > -kOverlap_s && appeared_s < kAtOnce_s && unseen_s > kUnseen_s &&
        t_s - balls_[i].began_s > std::max(kStays_s, 2 * (appeared_s - kUsual_s)) && lies(other, t_s) &&
        other.has_no_surprises() && other.sightings() >= kSteady) {
      first = i;
      continue;
    }
    const bool is_near = balls_[i].is_past || (unseen_s > kLately_s && reaches(shown, other));
    if (!is_sure(other, t_s, !is_near)) continue;
    // A stationary ball elsewhere is not the hidden ball.
    const bool may_be_it = balls_[i].is_past || !lies(other, t_s);
    const bool shown_is_unseen = may_be_it && unseen_s > (is_near ? kUnseen_s : kLost_s);
    const bool shown_is_young = may_be_it && shown.sightings() < kOld &&
                                other.sightings() > 2 * shown.sightings() && unseen_s > kLately_s / 2;
    // Balls beside the field are stationary; the ball in play moves.
    const bool is_played = other.sightings() > kPlayed && other.moved_s() > shown.moved_s() + kStill_s;
    if (shown_is_unseen || shown_is_young || is_played) first = i;
  }
  if (first != 0) std::swap(balls_[0], balls_[first]);
  balls_[0].is_past = false;
  // Drop hypotheses from before a turn once the turn is certain, and duplicates on the same trajectory.
  for (std::size_t i = balls_.size(); i-- > 1;) {
    const Ball& other = balls_[i];
    const bool is_over = other.is_past && balls_[0].track.sightings() >= kOld &&
                         balls_[0].track.seen_s() > other.track.seen_s();
    const auto b = other.track.at(t_s, robots);
    constexpr double kSameMm = 15, kSame_mm_s = 300;
    const bool is_same =
        std::any_of(balls_.begin(), balls_.begin() + static_cast<std::ptrdiff_t>(i), [&](const Ball& one) {
          const auto a = one.track.at(t_s, robots);
          return !one.is_past && (a.place_mm - b.place_mm).norm() < kSameMm &&
                 (a.velocity_mm_s - b.velocity_mm_s).norm() < kSame_mm_s;
        });
    if (is_over || is_same || i >= kMost) balls_.erase(balls_.begin() + static_cast<std::ptrdiff_t>(i));
  }
}

void BallTracks::take_kick() {
  if (!is_known_ || !balls_[0].track.kick()) return;
  const TrackedKick& kick = *balls_[0].track.kick();
  const std::pair which{balls_[0].number, kick.number};
  if (which != kick_of_ball_) {
    if (kick_ && kick.t_s < kick_->t_s + 0.02) return;  // an earlier kick
    kick_of_ball_ = which;
    ++kicks_;
  }
  kick_ = kick;
  kick_->number = kicks_;
  const BallShot shot{.t_s = kick.t_s, .place_mm = kick.place_mm, .velocity_mm_s = kick.velocity_mm_s};
  kick_->stop_s = shot.stops_s(model_);
  kick_->stop_mm = shot.at(kick_->stop_s, model_).place_mm.head<2>();
}

/// Starts a track from at least three measurements on a straight line that no track explains.
void BallTracks::look_for_balls(const std::vector<BallObservation>& seen, const RobotTracks& robots) {
  constexpr double kLasts_s = 0.1, kFastest_mm_s = 7000, kNearMm = 3, kStraightMm = 8;
  const double t_s = seen.front().t_s;
  std::erase_if(unexplained_, [&](const auto& one) { return one.t_s < t_s - kLasts_s; });
  for (const BallObservation& now : seen) {
    if (now.is_over_robot) continue;
    if (std::any_of(balls_.begin(), balls_.end(),
                    [&](const Ball& ball) { return ball.track.explains(now, robots); }))
      continue;
    const auto may_be_it = [&](const BallObservation& one) {
      const double passed_s = now.t_s - one.t_s;
      return passed_s > 1e-3 && (one.place_mm - now.place_mm).norm() < kFastest_mm_s * passed_s + kNearMm;
    };
    const auto count = std::count_if(unexplained_.begin(), unexplained_.end(), may_be_it);
    constexpr int kEnough = 2;
    if (count >= kEnough) {
      const BallObservation *first = nullptr, *middle = nullptr;
      for (std::ptrdiff_t left = count; const BallObservation& one : unexplained_) {
        if (!may_be_it(one)) continue;
        if (!first) first = &one;
        if (left-- == count - count / 2) middle = &one;
      }
      const Vector2d velocity = (now.place_mm - first->place_mm) / (now.t_s - first->t_s);
      if ((first->place_mm + velocity * (middle->t_s - first->t_s) - middle->place_mm).norm() < kStraightMm) {
        const Ball found{BallTrack(model_, now, velocity, static_cast<int>(count) + 1), ++numbers_, false,
                         t_s};
        balls_.push_back(found);
        unexplained_.clear();
        continue;
      }
    }
    unexplained_.push_back(now);
  }
}

void BallTracks::at(double t_s, const RobotTracks& robots, std::vector<TrackedBall>& out) const {
  out.clear();
  for (std::size_t i = 0; i < balls_.size(); ++i) {
    const Ball& ball = balls_[i];
    const bool is_played = is_known_ && i == 0;
    if (ball.is_past || ball.track.is_gone(t_s) || !(is_played || is_sure(ball.track, t_s, is_known_)))
      continue;
    out.push_back(ball.track.at(t_s, robots));
  }
}

std::optional<double> BallTracks::played_seen_s() const {
  if (!is_known_) return {};
  return balls_[0].track.seen_s();
}

std::optional<TrackedBall> BallTracks::played_at(double t_s, const RobotTracks& robots) const {
  if (!is_known_ || balls_[0].track.is_gone(t_s)) return {};
  return balls_[0].track.at(t_s, robots);
}

}  // namespace sslv
