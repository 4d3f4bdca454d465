// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tracking/ball_tracks.h"
#include "tracking/robot_tracks.h"
#include "tracking/sightings.h"
#include "tracking/tracks.h"

#include <cstdint>
#include <optional>

namespace sslv {

/// Tracks and predicts robots and balls from the measurements of all cameras. One thread, no I/O; knows only
/// the time of the observations.
class Tracker {
 public:
  /// Takes effect from now on.
  void set_ball_model(const BallModel& model) { balls_.set_model(model); }
  /// Notes that one of this computer's cameras took an image, with or without robots.
  void look(int camera, double t_s) { robots_.look(camera, t_s); }
  /// Adds the measurements of one image.
  void add(const Observations& observations);

  /// The robot predicted to `t_s`; none if it is not on the field.
  std::optional<TrackedRobot> robot(const RobotName& name, double t_s) const { return robots_.at(name, t_s); }
  std::optional<TrackedBall> ball(double t_s) const { return balls_.played_at(t_s, robots_); }
  /// The newest kick.
  const std::optional<TrackedKick>& kick() const { return balls_.kick(); }
  /// Number of resets and drops because of filters or measurements that were not finite.
  std::uint64_t repaired() const { return robots_.repaired() + balls_.repaired(); }
  /// Sets `out` to the field predicted to `t_s`, keeping its number.
  void at(double t_s, TrackedField& out) const;

 private:
  RobotTracks robots_;
  BallTracks balls_;
};

}  // namespace sslv
