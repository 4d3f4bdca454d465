// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tracking/camera_agreement.h"
#include "tracking/frame_clock.h"
#include "tracking/robot_track.h"
#include "tracking/sightings.h"
#include "tracking/tracks.h"

#include <map>
#include <optional>

#include <Eigen/Core>

namespace sslv {

/// Makes one field of what several cameras see. One thread, no I/O; knows no time but that of the sightings.
class Tracker {
 public:
  /// Where a camera hangs. To be called before its first sightings, and again when it was calibrated.
  void set_camera(int camera, const Eigen::Vector3d& center_mm, double robot_height_mm);
  void add(const CameraSightings& sightings);

  /// Nothing for a robot that is not on the field.
  std::optional<TrackedRobot> robot(const RobotName& name, double t_s) const;
  const CameraAgreement& agreement() const { return agreement_; }

 private:
  void add_robot(int camera, double t_s, const RobotSighting& sighting);

  std::optional<double> newest_s_;
  std::map<int, FrameClock> clocks_;
  CameraAgreement agreement_;
  std::map<RobotName, RobotTrack> robots_;
};

}  // namespace sslv
