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
  void look_for_balls();
  void choose_ball(double t_s);
  void take_kick();

  std::optional<double> newest_s_;
  std::map<int, FrameClock> clocks_;
  std::map<int, Eigen::Vector3d> centers_mm_;
  CameraAgreement agreement_;
  RobotTracks robots_;
  BallModel model_;
  /// All that may be the ball, the one that is shown first: others, and what it was before its last turn.
  struct Ball {
    BallTrack track;
    int number;
    bool is_past = false;  // of one that turned since
  };
  std::vector<Ball> balls_;
  std::vector<BallTrack::Sighting> unexplained_;  // lately
  std::vector<BallTrack::Sighting> seen_;
  std::optional<TrackedKick> kick_;
  int numbers_ = 0, kicks_ = 0;
  std::pair<int, int> kick_of_ball_{0, 0};  // the ball's number, its kick's
};

}  // namespace sslv
