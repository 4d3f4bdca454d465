// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tracking/ball_tracks.h"
#include "tracking/robot_tracks.h"
#include "tracking/sightings.h"
#include "tracking/tracks.h"

#include <deque>
#include <map>
#include <optional>

#include <Eigen/Core>

namespace sslv {

/// Robots and balls as they are known some time later, for recordings: what a robot did after a moment tells
/// what it did then (the smoother of Rauch, Tung and Striebel, over the steps of the robots' filters), and a
/// ball that was hidden went from where it was seen last to where it was seen again. One thread, no I/O.
class Smoother {
 public:
  /// Of 0.05 s and more.
  explicit Smoother(double lag_s) : lag_s_(lag_s) {}

  /// From now on.
  void set_ball_model(const BallModel& model) { balls_.set_model(model); }
  /// What one image shows.
  void add(const Observations& observations);
  /// Makes `out` the field as it was that long before the newest image; its number stays.
  void at(TrackedField& out) const;

 private:
  struct RobotSteps {
    std::deque<RobotTrack::Step> steps;  // as long ago as is asked for, and the one before
    /// The same with what came later.
    RobotTrack::Step at(double t_s) const;
  };
  struct BallSeen {
    double t_s;
    TrackedBall ball;
  };

  std::optional<TrackedRobot> robot_at(const RobotName& name, const RobotSteps& robot, double t_s) const;
  std::optional<TrackedBall> ball_at(double t_s) const;

  double lag_s_;
  double newest_s_ = 0;
  RobotTracks robots_;
  BallTracks balls_;
  std::map<RobotName, RobotSteps> steps_;
  std::deque<BallSeen> ball_;
};

}  // namespace sslv
