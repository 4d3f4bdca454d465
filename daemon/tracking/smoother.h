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

/// Estimates robots and balls with a delay, for recordings: later measurements correct a robot's earlier
/// states (Rauch-Tung-Striebel smoother over the steps of the robots' filters), and the position of a hidden
/// ball is interpolated between the last position before and the first position after the gap. One thread, no
/// I/O.
class Smoother {
 public:
  /// `lag_s`: at least 0.05.
  explicit Smoother(double lag_s) : lag_s_(lag_s) {}

  /// Takes effect from now on.
  void set_ball_model(const BallModel& model) { balls_.set_model(model); }
  /// Adds the measurements of one image, received at `now_s`. Restarts if `now_s` is set back.
  void add(const Observations& observations, double now_s);
  /// Sets `out` to the field `lag_s` before the last `now_s`, keeping its number. Returns false if this time
  /// is before the first image.
  bool at(TrackedField& out) const;

 private:
  /// One track of a robot, from its first measurement until the robot was gone.
  struct Run {
    std::deque<RobotTrack::Step> steps;  // steps within the lag, and one step before it
    bool is_sure = false;
    /// The last step before `t_s`, smoothed with all later steps.
    RobotTrack::Step at(double t_s) const;
  };
  struct BallSeen {
    double t_s;
    TrackedBall ball;
  };

  void add_robot(const RobotObservation& seen);
  void add_ball(const BallObservation& seen);
  void take_kick();
  void forget(double before_s);
  std::optional<TrackedRobot> robot_at(const RobotName& name, const std::deque<Run>& runs, double t_s) const;
  std::optional<TrackedBall> ball_at(double t_s) const;

  double lag_s_;
  std::optional<double> first_s_;
  double newest_s_ = 0;
  RobotTracks robots_;
  BallTracks balls_;
  std::map<RobotName, std::deque<Run>> runs_;
  std::deque<BallSeen> ball_;
  std::deque<TrackedKick> kicks_;
};

}  // namespace sslv
