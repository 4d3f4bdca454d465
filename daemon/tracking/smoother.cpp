// SPDX-License-Identifier: Apache-2.0
#include "tracking/smoother.h"

#include "tracking/planar.h"

#include <algorithm>
#include <cmath>

namespace sslv {

using Eigen::Vector3d;

namespace {

/// 1 where it was seen, 0 in the middle of a long time in which it was not.
double visibility_at(double before_s, double after_s, double t_s) {
  const double unseen_s = std::min(t_s - before_s, after_s - t_s);
  constexpr double kHidden_s = 0.05, kGone_s = 0.5;
  return std::clamp(1 - (unseen_s - kHidden_s) / kGone_s, 0.0, 1.0);
}

}  // namespace

void Smoother::add(const Observations& observations) {
  const double t_s = !observations.robots.empty()  ? observations.robots.front().t_s
                     : !observations.balls.empty() ? observations.balls.front().t_s
                                                   : newest_s_;
  // Where the clock was set back, all that is known lies in the future.
  constexpr double kSetBack_s = 0.5;
  if (t_s < newest_s_ - kSetBack_s) {
    const BallModel model = balls_.model();
    *this = Smoother(lag_s_);
    set_ball_model(model);
  }
  newest_s_ = std::max(newest_s_, t_s);
  for (const RobotObservation& robot : observations.robots) {
    RobotTrack::Step step;
    if (!robots_.add(robot, &step)) continue;
    auto& steps = steps_[robot.name].steps;
    steps.push_back(step);
    while (steps.size() > 2 && steps[1].t_s < newest_s_ - lag_s_) steps.pop_front();
  }
  std::erase_if(steps_, [&](const auto& one) {
    return one.second.steps.back().t_s < newest_s_ - lag_s_ - RobotTrack::kGone_s;
  });
  balls_.add(observations.balls, robots_);
  if (observations.balls.empty()) return;
  if (balls_.played_seen_s() != t_s) return;
  const auto ball = balls_.played_at(t_s, robots_);
  if (!ball) return;
  const auto later =
      std::find_if(ball_.begin(), ball_.end(), [&](const BallSeen& one) { return one.t_s > t_s; });
  ball_.insert(later, {t_s, *ball});
  while (ball_.size() > 2 && ball_[1].t_s < newest_s_ - lag_s_) ball_.pop_front();
}

RobotTrack::Step Smoother::RobotSteps::at(double t_s) const {
  RobotTrack::Step out = steps.back();
  for (std::size_t i = steps.size() - 1; i-- > 0 && out.t_s > t_s;) {
    const RobotTrack::Step& later = steps[i + 1];
    if (later.is_first) return out;  // nothing tells what was before
    RobotTrack::Step here = steps[i];
    here.state += later.back * (out.state - later.predicted);
    const Vector3d off = out.angle - later.predicted_angle;
    here.angle += later.angle_back * Vector3d(around(off[0]), off[1], off[2]);
    out = here;
  }
  return out;
}

std::optional<TrackedRobot> Smoother::robot_at(const RobotName& name, const RobotSteps& robot,
                                               double t_s) const {
  const auto& steps = robot.steps;
  // What it is known to be by now, it was from the beginning.
  const auto known = robots_.tracks.find(name);
  if (known == robots_.tracks.end() || !known->second.is_sure()) return {};
  const double last_s = steps.back().t_s;
  if (t_s > last_s + RobotTrack::kGone_s) return {};
  const auto after =
      std::find_if(steps.begin(), steps.end(), [&](const auto& one) { return one.t_s >= t_s; });
  if (after == steps.begin() && after->is_first && after->t_s > t_s) return {};
  const double after_s = after == steps.end() ? t_s + RobotTrack::kGone_s : after->t_s,
               before_s = after == steps.begin() ? after_s : std::prev(after)->t_s;
  const RobotTrack::Step step = robot.at(t_s);
  TrackedRobot out = step.robot_at(name, t_s);
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
  // On the way from there to here, with the velocities that it had at both ends.
  const double passed_s = after->t_s - before.t_s, share = (t_s - before.t_s) / passed_s;
  const double s2 = share * share, s3 = s2 * share;
  const Vector3d from = before.ball.velocity_mm_s * passed_s, to = after->ball.velocity_mm_s * passed_s,
                 way = after->ball.place_mm - before.ball.place_mm;
  out.place_mm += from * (s3 - 2 * s2 + share) + way * (3 * s2 - 2 * s3) + to * (s3 - s2);
  out.velocity_mm_s =
      (from * (3 * s2 - 4 * share + 1) + way * 6 * (share - s2) + to * (3 * s2 - 2 * share)) / passed_s;
  out.visibility = visibility_at(before.t_s, after->t_s, t_s);
  return out;
}

void Smoother::at(TrackedField& out) const {
  const double t_s = newest_s_ - lag_s_;
  out.t_s = t_s;
  out.robots.clear();
  for (const auto& [name, robot] : steps_) {
    if (const auto one = robot_at(name, robot, t_s)) out.robots.push_back(*one);
  }
  out.balls.clear();
  if (const auto ball = ball_at(t_s)) out.balls.push_back(*ball);
  // What is known of a kick by now, once it has happened.
  const auto& kick = balls_.kick();
  if (kick && kick->t_s <= t_s) out.kick = kick;
}

}  // namespace sslv
