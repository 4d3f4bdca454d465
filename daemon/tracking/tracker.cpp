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
  out.repaired = repaired();
}

}  // namespace sslv
