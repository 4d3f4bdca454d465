// SPDX-License-Identifier: Apache-2.0
#include "tracking/robot_tracks.h"

#include <cmath>
#include <numbers>

namespace sslv {

using Eigen::Vector2d;

void RobotTracks::add(const RobotObservation& seen) {
  const auto known = tracks.find(seen.name);
  if (known == tracks.end()) {
    tracks.emplace(seen.name, RobotTrack(seen));
  } else {
    known->second.add(seen);
  }
}

std::optional<TrackedRobot> RobotTracks::at(const RobotName& name, double t_s) const {
  const auto known = tracks.find(name);
  if (known == tracks.end() || t_s - known->second.seen_s() > RobotTrack::kGone_s) return {};
  constexpr int kSure = 2;  // one sighting is a pattern misread
  if (known->second.sightings() < kSure) return {};
  return known->second.at(t_s);
}

std::optional<RobotTracks::Nearest> RobotTracks::nearest(const Vector2d& place_mm, double t_s) const {
  std::optional<Nearest> out;
  for (const auto& [name, track] : tracks) {
    const auto robot = at(name, t_s);
    if (!robot) continue;
    const Vector2d way = place_mm - robot->place_mm;
    if (out && out->distance_mm <= way.norm()) continue;
    const double off_rad =
        std::remainder(std::atan2(way.y(), way.x()) - robot->orientation_rad, 2 * std::numbers::pi);
    out = Nearest{*robot, way.norm(), std::abs(off_rad)};
  }
  return out;
}

}  // namespace sslv
