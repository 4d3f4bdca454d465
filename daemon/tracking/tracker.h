// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tracking/ball_track.h"
#include "tracking/camera_agreement.h"
#include "tracking/frame_clock.h"
#include "tracking/robot_track.h"
#include "tracking/sightings.h"
#include "tracking/tracks.h"

#include <map>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace sslv {

/// Makes one field of what several cameras see. One thread, no I/O; knows no time but that of the sightings.
class Tracker {
 public:
  /// Where a camera hangs. To be called before its first sightings, and again when it was calibrated.
  void set_camera(int camera, const Eigen::Vector3d& center_mm, double robot_height_mm);
  void add(const CameraSightings& sightings);

  /// Nothing for a robot that is not on the field.
  std::optional<TrackedRobot> robot(const RobotName& name, double t_s) const { return robots_.at(name, t_s); }
  std::optional<TrackedBall> ball(double t_s) const;
  /// The newest.
  const std::optional<TrackedKick>& kick() const { return kick_; }
  const CameraAgreement& agreement() const { return agreement_; }

 private:
  void add_robot(int camera, double t_s, const RobotSighting& sighting);
  void add_balls(const CameraSightings& sightings, double t_s);
  void look_for_ball(const std::vector<BallTrack::Sighting>& seen);

  std::optional<double> newest_s_;
  std::map<int, FrameClock> clocks_;
  std::map<int, Eigen::Vector3d> centers_mm_;
  CameraAgreement agreement_;
  RobotTracks robots_;
  BallModel model_;
  std::optional<BallTrack> ball_;
  std::vector<BallTrack::Sighting> lately_;  // while there is no ball
  std::vector<BallTrack::Sighting> seen_;
  std::optional<TrackedKick> kick_;
  int kicks_ = 0, kick_of_ball_ = 0;
};

}  // namespace sslv
