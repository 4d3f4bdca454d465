// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tracking/ball_tracks.h"
#include "tracking/robot_tracks.h"
#include "tracking/sightings.h"
#include "tracking/tracks.h"

#include <cstdint>
#include <optional>

namespace sslv {

/// Follows robots and balls through what all cameras see, and predicts them. One thread, no I/O; knows no
/// time but that of the observations.
class Tracker {
 public:
  /// Of the ball, from now on.
  void set_ball_model(const BallModel& model) { balls_.set_model(model); }
  /// One of this computer's cameras took an image, whatever it shows.
  void look(int camera, double t_s) { robots_.look(camera, t_s); }
  /// What one image shows.
  void add(const Observations& observations);

  /// Nothing for a robot that is not on the field.
  std::optional<TrackedRobot> robot(const RobotName& name, double t_s) const { return robots_.at(name, t_s); }
  std::optional<TrackedBall> ball(double t_s) const { return balls_.played_at(t_s, robots_); }
  /// The newest.
  const std::optional<TrackedKick>& kick() const { return balls_.kick(); }
  /// Filters that were not finite and were reset.
  std::uint64_t repaired() const { return robots_.repaired() + balls_.repaired(); }
  /// Makes `out` all of it at that moment; its number stays.
  void at(double t_s, TrackedField& out) const;

 private:
  RobotTracks robots_;
  BallTracks balls_;
};

}  // namespace sslv
