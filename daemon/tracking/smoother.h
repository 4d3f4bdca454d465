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
  /// What one image shows, at the moment `now_s` at which it came. Where that is set back, all begins again.
  void add(const Observations& observations, double now_s);
  /// Makes `out` the field as it was that long before the last `now_s`; its number stays. False: that was
  /// before the first image.
  bool at(TrackedField& out) const;

 private:
  /// One robot, from when it was seen until it was gone.
  struct Run {
    std::deque<RobotTrack::Step> steps;  // as long ago as is asked for, and the one before
    bool is_sure = false;
    /// The last step before `t_s`, with what came later.
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
