// SPDX-License-Identifier: Apache-2.0
#include "tracking/tracker.h"

#include <algorithm>

namespace sslv {

namespace {

constexpr double kRobotGone_s = 0.5;

}  // namespace

void Tracker::set_camera(int camera, const Eigen::Vector3d& center_mm, double robot_height_mm) {
  agreement_.set_camera(camera, center_mm, robot_height_mm);
}

void Tracker::add(const CameraSightings& sightings) {
  const double t_s = clocks_[sightings.camera].time_of(sightings.t_capture_s);
  if (newest_s_ && t_s > *newest_s_) agreement_.follow(t_s - *newest_s_);
  newest_s_ = std::max(t_s, newest_s_.value_or(t_s));
  for (const RobotSighting& sighting : sightings.robots) add_robot(sightings.camera, t_s, sighting);
}

void Tracker::add_robot(int camera, double t_s, const RobotSighting& seen) {
  const RobotName name{seen.team, seen.id};
  const Eigen::Vector2d place = seen.place_mm - agreement_.error_of(camera, seen.place_mm) -
                                agreement_.height_error_of(camera, name, seen.place_mm);
  const RobotTrack::Sighting sighting{camera,
                                      t_s - agreement_.time_offset_s(camera),
                                      clocks_[camera].sigma_s(),
                                      place,
                                      seen.orientation_rad,
                                      seen.place_cov_mm2,
                                      seen.orientation_sigma_rad};
  const auto known = robots_.find(name);
  if (known == robots_.end()) {
    robots_.emplace(name, RobotTrack(name, sighting));
  } else if (!known->second.add(sighting)) {
    return;
  }
  agreement_.see(camera, {name, seen.place_mm, t_s});
}

std::optional<TrackedRobot> Tracker::robot(const RobotName& name, double t_s) const {
  const auto known = robots_.find(name);
  if (known == robots_.end() || t_s - known->second.seen_s() > kRobotGone_s) return {};
  return known->second.at(t_s);
}

}  // namespace sslv
