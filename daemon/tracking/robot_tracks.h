// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tracking/robot_track.h"
#include "tracking/sightings.h"
#include "tracking/tracks.h"

#include <map>
#include <optional>

#include <Eigen/Core>

namespace sslv {

/// The robots on the field.
class RobotTracks {
 public:
  void add(const RobotObservation& seen);

  /// Nothing for one that is not on the field.
  std::optional<TrackedRobot> at(const RobotName& name, double t_s) const;
  struct Nearest {
    TrackedRobot robot;
    double distance_mm, from_front_rad;
  };
  /// To a place where a ball is.
  std::optional<Nearest> nearest(const Eigen::Vector2d& place_mm, double t_s) const;

  std::map<RobotName, RobotTrack> tracks;
};

}  // namespace sslv
