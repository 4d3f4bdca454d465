// SPDX-License-Identifier: Apache-2.0
#include "tracking/robot_tracks.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sslv {

using Eigen::Vector2d;

namespace {

/// Larger than any disagreement of calibrations and clocks, even before CameraAgreement has corrected it.
constexpr double kDraggedMm = 100;
/// Times of the same image differ by less than this.
constexpr double kSame_s = 0.004;

}  // namespace

void RobotTracks::look(int camera, double t_s) {
  Looks& looks = looks_.try_emplace(camera).first->second;
  if (std::abs(t_s - looks.taken_s[looks.newest]) < kSame_s) return;
  looks.newest = (looks.newest + 1) % looks.taken_s.size();
  looks.taken_s[looks.newest] = t_s;
}

bool RobotTracks::add_to(RobotTrack& track, const RobotObservation& seen,
                         const RobotTrack::Circumstances& now, RobotTrack::Step* step) {
  const bool is_taken = track.add(seen, now, step);
  if (track.is_finite()) return is_taken;
  track = RobotTrack(seen);  // finite: add() drops other measurements
  ++repaired_;
  if (step) *step = track.last_step();
  return true;
}

bool RobotTracks::add(const RobotObservation& seen, RobotTrack::Step* step) {
  if (!std::isfinite(seen.t_s + seen.place_mm.sum() + seen.orientation_rad + seen.height_mm)) {
    ++repaired_;
    return false;
  }
  if (seen.is_of_other_computer && !hears_others_) {
    hears_others_ = true;
    own_ = tracks;
  }
  if (!seen.is_of_other_computer) note_sight(seen);
  const auto known = tracks.find(seen.name);
  if (known == tracks.end()) {
    forget(seen.t_s);
    const RobotTrack& made = tracks.emplace(seen.name, RobotTrack(seen)).first->second;
    if (step) *step = made.last_step();
    return true;
  }
  RobotTrack& track = known->second;
  RobotTrack::Circumstances now{.touches = touches_another(seen)};
  if (seen.is_of_other_computer) {
    if (const RobotTrack* const own = seen_by_own(seen.name, seen.t_s)) {
      // The robot can only have left if our camera has since taken an image that does not show it.
      const Looks& looks = looks_.at(sights_.at(seen.name).camera);
      const double looked_s =
          std::clamp(looks.taken_s[looks.newest], own->seen_s(), std::max(own->seen_s(), seen.t_s));
      const double off_mm = (seen.place_mm - own->at(seen.t_s).place_mm).norm();
      if (off_mm > kDraggedMm + own->unforeseen_mm(looked_s)) return false;
      now.stays_here = true;
    }
    return add_to(track, seen, now, step);
  }
  const bool is_taken = add_to(track, seen, now, step);
  if (!hears_others_) return is_taken;
  add_own(seen, now, is_taken);
  const RobotTrack* const own = seen_by_own(seen.name, seen.t_s);
  if (!own || (track.at(seen.t_s).place_mm - own->at(seen.t_s).place_mm).norm() < kDraggedMm) return is_taken;
  track = *own;
  if (step) *step = track.last_step();
  return true;
}

void RobotTracks::forget(double t_s) {
  constexpr double kForgotten_s = 60;
  const auto is_old = [&](const auto& one) { return std::abs(t_s - one.second.seen_s()) > kForgotten_s; };
  std::erase_if(tracks, is_old);
  std::erase_if(own_, is_old);
  std::erase_if(sights_, [&](const auto& one) { return std::abs(t_s - one.second.seen_s) > kForgotten_s; });
}

void RobotTracks::note_sight(const RobotObservation& seen) {
  look(seen.camera, seen.t_s);
  const Looks& looks = looks_.at(seen.camera);
  Sight& sight = sights_[seen.name];
  const auto images = std::count_if(looks.taken_s.begin(), looks.taken_s.end(),
                                    [&](double taken_s) { return taken_s > sight.seen_s + kSame_s; });
  const bool is_gone = images == std::ssize(looks.taken_s) && seen.t_s - sight.seen_s > RobotTrack::kGone_s;
  if (is_gone || seen.t_s < sight.seen_s - RobotTrack::kGone_s) sight = {};
  constexpr double kLearns = 0.1;
  if (sight.sightings > 0) sight.every += kLearns * (static_cast<double>(images) - sight.every);
  ++sight.sightings;
  sight.camera = seen.camera;
  sight.seen_s = seen.t_s;
}

bool RobotTracks::is_seen_steadily(const RobotName& name) const {
  // Occasional misread patterns must not keep a robot away from the position at which another computer always
  // sees it.
  constexpr int kOld = 30;  // measurements after which `every` has settled
  constexpr double kSteady = 7;
  const auto sight = sights_.find(name);
  return sight != sights_.end() && sight->second.sightings >= kOld && sight->second.every <= kSteady;
}

const RobotTrack* RobotTracks::seen_by_own(const RobotName& name, double t_s) const {
  constexpr double kHeldUp_s = 2;
  const auto known = own_.find(name);
  if (known == own_.end() || !is_seen_steadily(name)) return nullptr;
  const RobotTrack& own = known->second;
  const Looks& looks = looks_.at(sights_.at(name).camera);
  // A camera without new images is delayed; after kHeldUp_s it no longer counts.
  const bool is_seen = looks.taken_s[looks.newest] - own.seen_s() < RobotTrack::kGone_s &&
                       std::abs(t_s - own.seen_s()) < kHeldUp_s;
  return is_seen ? &own : nullptr;
}

/// Own tracks start only from measurements that the common track accepts, so that the first of two robots
/// with the same id is kept. If our cameras see the robot steadily, it starts anyway: another computer may
/// have moved the common track while our cameras were held up.
void RobotTracks::add_own(const RobotObservation& seen, const RobotTrack::Circumstances& now, bool is_taken) {
  const auto known = own_.find(seen.name);
  if (known != own_.end() && std::abs(seen.t_s - known->second.seen_s()) < RobotTrack::kGone_s) {
    add_to(known->second, seen, now);
  } else if (is_taken || is_seen_steadily(seen.name)) {
    own_.insert_or_assign(seen.name, RobotTrack(seen));
  }
}

bool RobotTracks::touches_another(const RobotObservation& seen) const {
  // Robots are 180 mm wide; the other robot's position is one image old.
  constexpr double kTouchMm = 220, kLately_s = 0.05;
  return std::any_of(tracks.begin(), tracks.end(), [&](const auto& one) {
    return one.first != seen.name &&
           (one.second.place_mm() - seen.place_mm).squaredNorm() < kTouchMm * kTouchMm &&
           seen.t_s - one.second.seen_s() < kLately_s;
  });
}

/// Two robots cannot be at the same place: the track with more measurements is the right one.
bool RobotTracks::is_misread(const RobotName& name, const RobotTrack& track, double t_s) const {
  constexpr int kOld = 10;
  constexpr double kSameMm = 100, kLately_s = 0.1;
  if (track.sightings() >= kOld) return false;
  const Vector2d place = track.at(t_s).place_mm;
  return std::any_of(tracks.begin(), tracks.end(), [&](const auto& one) {
    const RobotTrack& other = one.second;
    return one.first != name && other.sightings() > track.sightings() && t_s - other.seen_s() < kLately_s &&
           (other.at(t_s).place_mm - place).squaredNorm() < kSameMm * kSameMm;
  });
}

bool RobotTracks::is_over_robot(const BallObservation& ball, double ball_radius_mm) const {
  // Smaller than any robot's top, because the robot's height is not well known.
  constexpr double kTopMm = 65, kSeen = 0.99;
  constexpr int kOld = 10;
  const Vector2d below_camera = ball.camera_mm.head<2>();
  const double height_mm = ball.camera_mm.z();
  return std::any_of(tracks.begin(), tracks.end(), [&](const auto& one) {
    const RobotTrack& robot = one.second;
    if (robot.sightings() < kOld) return false;
    const double share = (height_mm - robot.height_mm()) / (height_mm - ball_radius_mm);
    const Vector2d at_top = below_camera + share * (ball.place_mm - below_camera);
    constexpr double kNearMm = 400;  // distance from the last position: cheap check before predicting
    if ((robot.place_mm() - at_top).squaredNorm() > kNearMm * kNearMm) return false;
    const TrackedRobot now = robot.at(ball.t_s);
    return now.visibility > kSeen && (now.place_mm - at_top).squaredNorm() < kTopMm * kTopMm;
  });
}

std::optional<TrackedRobot> RobotTracks::at(const RobotName& name, double t_s) const {
  const auto known = tracks.find(name);
  if (known == tracks.end() || t_s - known->second.seen_s() > RobotTrack::kGone_s) return {};
  if (!known->second.is_sure() || is_misread(name, known->second, t_s)) return {};
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
