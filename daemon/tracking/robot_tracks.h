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

/// The robots on the field. Another computer may be wrong in all that it says: where this one's cameras see a
/// robot steadily, what the other says takes it nowhere else. Whether they do is counted in their images, not
/// in time: a busy computer holds its own cameras up and hears the others all the same.
class RobotTracks {
 public:
  /// One of this computer's cameras took an image, whether it shows robots or none.
  void look(int camera, double t_s);
  /// False: it cannot be the robot that it says. `step`: as RobotTrack::add.
  bool add(const RobotObservation& seen, RobotTrack::Step* step = nullptr);
  /// Whether a camera sees the top of a robot where it sees this ball, so that the ball is not on the floor.
  bool is_over_robot(const BallObservation& ball, double ball_radius_mm) const;

  /// Nothing for one that is not on the field.
  std::optional<TrackedRobot> at(const RobotName& name, double t_s) const;
  struct Nearest {
    TrackedRobot robot;
    double distance_mm, from_front_rad;
  };
  /// To a place where a ball is.
  std::optional<Nearest> nearest(const Eigen::Vector2d& place_mm, double t_s) const;

  /// Filters that were not finite and were reset, and sightings that would have begun such a one.
  std::uint64_t repaired() const { return repaired_; }

  std::map<RobotName, RobotTrack> tracks;

 private:
  /// By this computer's cameras, as far as they took images.
  bool is_seen_steadily(const RobotName& name) const;
  /// The same robot as this computer's cameras alone see it; null: not steadily, or not lately.
  const RobotTrack* seen_by_own(const RobotName& name, double t_s) const;
  /// As RobotTrack::add(); resets a filter that is not finite.
  bool add_to(RobotTrack& track, const RobotObservation& seen, const RobotTrack::Circumstances& now,
              RobotTrack::Step* step = nullptr);
  void add_own(const RobotObservation& seen, const RobotTrack::Circumstances& now, bool is_taken);
  bool touches_another(const RobotObservation& seen) const;
  bool is_misread(const RobotName& name, const RobotTrack& track, double t_s) const;

  /// What this computer's cameras have made of a robot.
  struct Sight {
    int camera = 0;        // that saw it last
    double seen_s = -1e9;  // then
    int sightings = 0;     // without having been looked for in vain for long
    double every = 1;      // how many images of a camera there are to one that shows it
  };
  /// When a camera of this computer took its last images.
  struct Looks {
    std::array<double, 8> taken_s{};
    std::size_t newest = 0;
  };

  void note_sight(const RobotObservation& seen);
  void forget(double t_s);

  bool hears_others_ = false;  // until then, `tracks` are what own cameras see
  std::map<RobotName, RobotTrack> own_;
  std::map<RobotName, Sight> sights_;
  std::map<int, Looks> looks_;  // by camera
  std::uint64_t repaired_ = 0;
};

}  // namespace sslv
