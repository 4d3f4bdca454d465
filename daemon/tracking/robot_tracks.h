// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tracking/robot_track.h"
#include "tracking/sightings.h"
#include "tracking/tracks.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>

#include <Eigen/Core>

namespace sslv {

/// The robots on the field. Measurements of other computers may be wrong, so they cannot move a robot away
/// from the position at which this computer's cameras see it steadily. "Steadily" is measured in images of
/// these cameras, not in time, because a busy computer delays its own cameras' images but still receives the
/// measurements of other computers.
class RobotTracks {
 public:
  /// Notes that one of this computer's cameras took an image, with or without robots.
  void look(int camera, double t_s);
  /// Returns false if the measurement is dropped: not finite, or not of the robot that it names. `step`: see
  /// RobotTrack::add().
  bool add(const RobotObservation& seen, RobotTrack::Step* step = nullptr);
  /// Whether the camera sees the ball in front of a robot's top, so that the ball is not on the floor.
  bool is_over_robot(const BallObservation& ball, double ball_radius_mm) const;

  /// The robot predicted to `t_s`; none if it is not on the field, not yet sure, or misread.
  std::optional<TrackedRobot> at(const RobotName& name, double t_s) const;
  struct Nearest {
    TrackedRobot robot;
    double distance_mm, from_front_rad;
  };
  /// The robot that is nearest to a ball's position, if any.
  std::optional<Nearest> nearest(const Eigen::Vector2d& place_mm, double t_s) const;

  /// Number of filters that were reset and measurements that were dropped because they were not finite.
  std::uint64_t repaired() const { return repaired_; }

  std::map<RobotName, RobotTrack> tracks;

 private:
  /// Whether this computer's cameras show the robot in a sufficient share of their images.
  bool is_seen_steadily(const RobotName& name) const;
  /// The robot's track from this computer's cameras alone; null if not seen steadily or not recently.
  const RobotTrack* seen_by_own(const RobotName& name, double t_s) const;
  /// Calls RobotTrack::add(), and resets a filter that is not finite.
  bool add_to(RobotTrack& track, const RobotObservation& seen, const RobotTrack::Circumstances& now,
              RobotTrack::Step* step = nullptr);
  void add_own(const RobotObservation& seen, const RobotTrack::Circumstances& now, bool is_taken);
  bool touches_another(const RobotObservation& seen) const;
  bool is_misread(const RobotName& name, const RobotTrack& track, double t_s) const;

  /// Statistics of the measurements of a robot by this computer's cameras.
  struct Sight {
    int camera = 0;        // the last camera that saw the robot
    double seen_s = -1e9;  // time of the last measurement
    int sightings = 0;     // number of measurements since the robot was last lost
    double every = 1;      // mean number of images of a camera per image that shows it
  };
  /// Times of the last images of a camera of this computer.
  struct Looks {
    std::array<double, 8> taken_s{};
    std::size_t newest = 0;
  };

  void note_sight(const RobotObservation& seen);
  void forget(double t_s);

  bool hears_others_ = false;  // false: `tracks` are from own cameras only
  std::map<RobotName, RobotTrack> own_;
  std::map<RobotName, Sight> sights_;
  std::map<int, Looks> looks_;  // by camera
  std::uint64_t repaired_ = 0;
};

}  // namespace sslv
