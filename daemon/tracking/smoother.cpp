// SPDX-License-Identifier: Apache-2.0
#include "tracking/smoother.h"

#include "tracking/planar.h"

#include <algorithm>
#include <cmath>

namespace sslv {

using Eigen::Vector3d;

namespace {

/// Delay from the exposure to the arrival of an image's measurements.
constexpr double kWay_s = 0.1;

/// 1 near a measurement, 0 in the middle of a long gap.
double visibility_at(double before_s, double after_s, double t_s) {
  const double unseen_s = std::min(t_s - before_s, after_s - t_s);
  constexpr double kHidden_s = 0.05, kGone_s = 0.5;
  return std::clamp(1 - (unseen_s - kHidden_s) / kGone_s, 0.0, 1.0);
}

}  // namespace

void Smoother::add(const Observations& observations, double now_s) {
  // Once the clock is set back, all previous measurements lie in the future.
  constexpr double kSetBack_s = 0.5;
  if (now_s < newest_s_ - kSetBack_s) {
    const BallModel model = balls_.model();
    *this = Smoother(lag_s_);
    set_ball_model(model);
  }
  if (!first_s_) first_s_ = now_s;
  newest_s_ = std::max(newest_s_, now_s);
  for (const RobotObservation& robot : observations.robots) add_robot(robot);
  balls_.add(observations.balls, robots_);
  if (!observations.balls.empty()) add_ball(observations.balls.front());
  take_kick();
  forget(newest_s_ - lag_s_);
}

void Smoother::add_robot(const RobotObservation& seen) {
  RobotTrack::Step step;
  if (!robots_.add(seen, &step)) return;
  std::deque<Run>& runs = runs_[seen.name];
  if (step.is_first || runs.empty()) {
    // A track that never became sure was not a robot.
    if (!runs.empty() && !runs.back().is_sure) runs.pop_back();
    runs.emplace_back();
  }
  runs.back().steps.push_back(step);
  // A track that becomes sure counts as sure from its beginning.
  runs.back().is_sure = runs.back().is_sure || robots_.tracks.at(seen.name).is_sure();
}

void Smoother::add_ball(const BallObservation& seen) {
  if (balls_.played_seen_s() != seen.t_s) return;
  const auto ball = balls_.played_at(seen.t_s, robots_);
  if (!ball) return;
  const auto later =
      std::find_if(ball_.begin(), ball_.end(), [&](const BallSeen& one) { return one.t_s > seen.t_s; });
  ball_.insert(later, {seen.t_s, *ball});
}

/// Updates the newest kick, whose estimate still improves, or adds a new one.
void Smoother::take_kick() {
  const auto& kick = balls_.kick();
  if (!kick) return;
  if (kicks_.empty() || kicks_.back().number != kick->number) kicks_.emplace_back();
  kicks_.back() = *kick;
}

void Smoother::forget(double before_s) {
  for (auto& [name, runs] : runs_) {
    for (Run& run : runs) {
      while (run.steps.size() > 2 && run.steps[1].t_s < before_s) run.steps.pop_front();
    }
    while (!runs.empty() && runs.front().steps.back().t_s < before_s - RobotTrack::kGone_s) runs.pop_front();
  }
  std::erase_if(runs_, [](const auto& one) { return one.second.empty(); });
  while (ball_.size() > 2 && ball_[1].t_s < before_s) ball_.pop_front();
  while (kicks_.size() > 1 && kicks_[1].t_s < before_s) kicks_.pop_front();
}

RobotTrack::Step Smoother::Run::at(double t_s) const {
  RobotTrack::Step out = steps.back();
  for (std::size_t i = steps.size() - 1; i-- > 0 && out.t_s > t_s;) {
    const RobotTrack::Step& later = steps[i + 1];
    RobotTrack::Step here = steps[i];
    here.state += later.back * (out.state - later.predicted);
    const Vector3d off = out.angle - later.predicted_angle;
    here.angle += later.angle_back * Vector3d(around(off[0]), off[1], off[2]);
    out = here;
  }
  return out;
}

std::optional<TrackedRobot> Smoother::robot_at(const RobotName& name, const std::deque<Run>& runs,
                                               double t_s) const {
  const Run* run = nullptr;
  double again_s = t_s + RobotTrack::kGone_s;  // time at which the robot was seen again
  for (const Run& one : runs) {
    if (!one.is_sure) continue;
    if (one.steps.front().t_s > t_s) {
      again_s = std::min(again_s, one.steps.front().t_s);
      break;
    }
    run = &one;
  }
  if (!run || t_s > run->steps.back().t_s + RobotTrack::kGone_s) return {};
  const auto& steps = run->steps;
  const auto after =
      std::find_if(steps.begin(), steps.end(), [&](const auto& one) { return one.t_s >= t_s; });
  const double after_s = after == steps.end() ? again_s : after->t_s,
               before_s = after == steps.begin() ? after_s : std::prev(after)->t_s;
  TrackedRobot out = run->at(t_s).robot_at(name, t_s);
  out.visibility = visibility_at(before_s, after_s, t_s);
  return out;
}

std::optional<TrackedBall> Smoother::ball_at(double t_s) const {
  constexpr double kGone_s = 0.8;
  const auto after =
      std::find_if(ball_.begin(), ball_.end(), [&](const BallSeen& one) { return one.t_s >= t_s; });
  if (after == ball_.begin()) {
    if (after == ball_.end() || after->t_s > t_s) return {};
    return after->ball;
  }
  const BallSeen& before = *std::prev(after);
  TrackedBall out = before.ball;
  if (after == ball_.end()) {
    if (t_s - before.t_s > kGone_s) return {};
    out.place_mm += out.velocity_mm_s * (t_s - before.t_s);
    out.visibility = visibility_at(before.t_s, t_s + kGone_s, t_s);
    return out;
  }
  // Cubic Hermite interpolation with the velocities at both ends, limited in case the ball hit something.
  const double passed_s = after->t_s - before.t_s, share = (t_s - before.t_s) / passed_s;
  const double s2 = share * share, s3 = s2 * share;
  const Vector3d way = after->ball.place_mm - before.ball.place_mm;
  const auto at_most = [&](const Vector3d& goes) -> Vector3d {
    constexpr double kTimes = 3;  // larger velocities overshoot the end and return
    const double most = kTimes * way.norm(), length = goes.norm();
    return length > most ? Vector3d(goes * (most / length)) : goes;
  };
  const Vector3d from = at_most(before.ball.velocity_mm_s * passed_s),
                 to = at_most(after->ball.velocity_mm_s * passed_s);
  out.place_mm += from * (s3 - 2 * s2 + share) + way * (3 * s2 - 2 * s3) + to * (s3 - s2);
  out.velocity_mm_s =
      (from * (3 * s2 - 4 * share + 1) + way * 6 * (share - s2) + to * (3 * s2 - 2 * share)) / passed_s;
  out.visibility = visibility_at(before.t_s, after->t_s, t_s);
  return out;
}

bool Smoother::at(TrackedField& out) const {
  const double t_s = newest_s_ - lag_s_;
  if (!first_s_ || t_s < *first_s_ - kWay_s) return false;
  out.t_s = t_s;
  out.robots.clear();
  for (const auto& [name, runs] : runs_) {
    if (const auto one = robot_at(name, runs, t_s)) out.robots.push_back(*one);
  }
  out.balls.clear();
  if (const auto ball = ball_at(t_s)) out.balls.push_back(*ball);
  out.kick.reset();
  for (const TrackedKick& kick : kicks_) {
    if (kick.t_s <= t_s) out.kick = kick;
  }
  return true;
}

}  // namespace sslv
