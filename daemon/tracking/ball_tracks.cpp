// SPDX-License-Identifier: Apache-2.0
#include "tracking/ball_tracks.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sslv {

using Eigen::Vector2d;

namespace {

/// A ball that was not seen for so long may be anywhere.
constexpr double kBallGone_s = 0.8;

}  // namespace

void BallTracks::add(const std::vector<BallObservation>& seen, const RobotTracks& robots) {
  if (seen.empty()) return;
  const double now_s = seen.front().t_s;
  // What one that is looked at since long explains is not what another has turned to.
  const std::size_t count = balls_.size();  // without what is added here
  for (std::size_t i = 0; i < count; ++i) {
    Ball& ball = balls_[i];
    own_ = seen;
    if (own_.size() > 1) {
      std::erase_if(own_, [&](const auto& one) {
        return std::any_of(balls_.begin(), balls_.end(), [&](const Ball& other) {
          return &other != &ball && !other.is_past && !ball.is_past &&
                 other.track.sightings() > ball.track.sightings() && other.track.explains(one, robots);
        });
      });
    }
    Ball before = ball;
    switch (ball.track.add(own_, robots)) {
      case BallTrack::Saw::kTurn:
        if (before.is_past) {  // only what it was is of use
          ball = before;
          break;
        }
        before.is_past = true;
        balls_.push_back(std::move(before));
        break;
      case BallTrack::Saw::kBall:
      case BallTrack::Saw::kNothing: break;
    }
  }
  look_for_balls(seen, robots);
  choose_ball(now_s, robots);
  take_kick();
}

void BallTracks::choose_ball(double t_s, const RobotTracks& robots) {
  std::erase_if(balls_, [&](const Ball& ball) {
    return t_s - ball.track.seen_s() > kBallGone_s || ball.track.is_too_fast();
  });
  constexpr std::size_t kMost = 6;
  constexpr double kLately_s = 0.03, kUnseen_s = 0.05, kHidden_s = 0.5;
  constexpr int kOld = 8, kSure = 3, kPlayed = 6;
  constexpr double kStill_s = 1;
  if (balls_.empty()) return;
  // One that turned was not it when what it was before is seen again, and it is not.
  std::size_t first = 0;
  for (std::size_t i = 1; i < balls_.size(); ++i) {
    const BallTrack &shown = balls_[first].track, &other = balls_[i].track;
    if (t_s - other.seen_s() > kLately_s || other.sightings() < kSure) continue;
    // A ball that lies still elsewhere is not the one that is hidden.
    const bool lies = t_s - other.moved_s() > kUnseen_s;
    const bool shown_is_unseen = other.seen_s() - shown.seen_s() > (lies ? kHidden_s : kUnseen_s);
    const bool shown_is_young = shown.sightings() < kOld && other.sightings() > 2 * shown.sightings() &&
                                other.seen_s() - shown.seen_s() > kLately_s / 2;
    // Balls beside the field lie still; the one that is played does not.
    const bool is_played = other.sightings() > kPlayed && other.moved_s() > shown.moved_s() + kStill_s;
    if (shown_is_unseen || shown_is_young || is_played) first = i;
  }
  if (first != 0) std::swap(balls_[0], balls_[first]);
  balls_[0].is_past = false;
  // What one was before its turn is of no use once the turn is sure; two on one way are one.
  for (std::size_t i = balls_.size(); i-- > 1;) {
    const Ball& other = balls_[i];
    const bool is_over = other.is_past && balls_[0].track.sightings() >= kOld &&
                         balls_[0].track.seen_s() > other.track.seen_s();
    const auto a = balls_[0].track.at(t_s, robots), b = other.track.at(t_s, robots);
    constexpr double kSameMm = 15, kSame_mm_s = 300;
    const bool is_same =
        (a.place_mm - b.place_mm).norm() < kSameMm && (a.velocity_mm_s - b.velocity_mm_s).norm() < kSame_mm_s;
    if (is_over || is_same || i >= kMost) balls_.erase(balls_.begin() + static_cast<std::ptrdiff_t>(i));
  }
}

void BallTracks::take_kick() {
  if (balls_.empty() || !balls_[0].track.kick()) return;
  const TrackedKick& kick = *balls_[0].track.kick();
  const std::pair which{balls_[0].number, kick.number};
  if (which != kick_of_ball_) {
    if (kick_ && kick.t_s < kick_->t_s + 0.02) return;  // of a past one
    kick_of_ball_ = which;
    ++kicks_;
  }
  kick_ = kick;
  kick_->number = kicks_;
}

/// Three sightings that one ball on its way may be, and that no other explains.
void BallTracks::look_for_balls(const std::vector<BallObservation>& seen, const RobotTracks& robots) {
  constexpr double kLately_s = 0.1, kFastest_mm_s = 7000, kNearMm = 3, kStraightMm = 8;
  const double t_s = seen.front().t_s;
  std::erase_if(unexplained_, [&](const auto& one) { return one.t_s < t_s - kLately_s; });
  for (const BallObservation& now : seen) {
    if (std::any_of(balls_.begin(), balls_.end(),
                    [&](const Ball& ball) { return ball.track.explains(now, robots); }))
      continue;
    std::vector<const BallObservation*> before;
    for (const BallObservation& one : unexplained_) {
      const double passed_s = now.t_s - one.t_s;
      if (passed_s > 1e-3 && (one.place_mm - now.place_mm).norm() < kFastest_mm_s * passed_s + kNearMm)
        before.push_back(&one);
    }
    constexpr std::size_t kEnough = 2;
    if (before.size() >= kEnough) {
      const BallObservation &first = *before.front(), &middle = *before[before.size() / 2];
      const Vector2d velocity = (now.place_mm - first.place_mm) / (now.t_s - first.t_s);
      if ((first.place_mm + velocity * (middle.t_s - first.t_s) - middle.place_mm).norm() < kStraightMm) {
        balls_.push_back({BallTrack(model_, now, velocity, static_cast<int>(before.size()) + 1), ++numbers_});
        unexplained_.clear();
        continue;
      }
    }
    unexplained_.push_back(now);
  }
}

std::vector<TrackedBall> BallTracks::at(double t_s, const RobotTracks& robots) const {
  std::vector<TrackedBall> out;
  for (const Ball& ball : balls_) {
    if (ball.is_past || t_s - ball.track.seen_s() > kBallGone_s) continue;
    out.push_back(ball.track.at(t_s, robots));
  }
  return out;
}

std::optional<TrackedBall> BallTracks::played_at(double t_s, const RobotTracks& robots) const {
  if (balls_.empty() || t_s - balls_[0].track.seen_s() > kBallGone_s) return {};
  return balls_[0].track.at(t_s, robots);
}

}  // namespace sslv
