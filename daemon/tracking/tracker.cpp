// SPDX-License-Identifier: Apache-2.0
#include "tracking/tracker.h"

namespace sslv {

void Tracker::add(const Observations& observations) {
  for (const RobotObservation& robot : observations.robots) robots_.add(robot);
  balls_.add(observations.balls, robots_);
}

void Tracker::at(double t_s, TrackedField& out) const {
  out.t_s = t_s;
  out.robots.clear();
  for (const auto& [name, track] : robots_.tracks) {
    if (auto robot = robots_.at(name, t_s)) out.robots.push_back(*robot);
  }
  balls_.at(t_s, robots_, out.balls);
  out.kick = balls_.kick();
  if (!out.kick) return;
  const BallShot shot{
      .t_s = out.kick->t_s, .place_mm = out.kick->place_mm, .velocity_mm_s = out.kick->velocity_mm_s};
  out.kick->stop_s = shot.stops_s(balls_.model());
  out.kick->stop_mm = shot.at(out.kick->stop_s, balls_.model()).place_mm.head<2>();
}

}  // namespace sslv
