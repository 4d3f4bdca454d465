// SPDX-License-Identifier: Apache-2.0
#include "tracking/tracker.h"

#include <algorithm>
#include <cmath>

namespace sslv {

using Eigen::Vector2d;

namespace {

/// A ball that was not seen for so long may be anywhere.
constexpr double kBallGone_s = 0.8;
/// What a calibration differs by from place to place.
constexpr double kBallPlaceSigmaMm = 0.3;

}  // namespace

void Tracker::set_camera(int camera, const Eigen::Vector3d& center_mm, double robot_height_mm) {
  centers_mm_[camera] = center_mm;
  agreement_.set_camera(camera, center_mm, robot_height_mm);
}

void Tracker::add(const CameraSightings& sightings) {
  const double t_s = clocks_[sightings.camera].time_of(sightings.t_capture_s);
  if (newest_s_ && t_s > *newest_s_) agreement_.follow(t_s - *newest_s_);
  newest_s_ = std::max(t_s, newest_s_.value_or(t_s));
  for (const RobotSighting& sighting : sightings.robots) add_robot(sightings.camera, t_s, sighting);
  add_balls(sightings, t_s);
}

void Tracker::add_robot(int camera, double t_s, const RobotSighting& seen) {
  const RobotName name{seen.team, seen.id};
  const Vector2d place = seen.place_mm - agreement_.error_of(camera, seen.place_mm) -
                         agreement_.height_error_of(camera, name, seen.place_mm);
  const RobotTrack::Sighting sighting{camera,
                                      t_s - agreement_.time_offset_s(camera),
                                      clocks_[camera].sigma_s(),
                                      place,
                                      seen.orientation_rad,
                                      seen.place_cov_mm2,
                                      seen.orientation_sigma_rad};
  const auto known = robots_.tracks.find(name);
  if (known == robots_.tracks.end()) {
    robots_.tracks.emplace(name, RobotTrack(name, sighting));
  } else if (!known->second.add(sighting)) {
    return;
  }
  agreement_.see(camera, {name, seen.place_mm, t_s});
}

void Tracker::add_balls(const CameraSightings& sightings, double t_s) {
  const auto center = centers_mm_.find(sightings.camera);
  if (center == centers_mm_.end()) return;
  seen_.clear();
  for (const BallSighting& ball : sightings.balls) {
    const double sigma_mm = std::sqrt(ball.place_cov_mm2.trace() / 2);
    seen_.push_back({t_s - agreement_.time_offset_s(sightings.camera), center->second, ball.place_mm,
                     std::hypot(sigma_mm, kBallPlaceSigmaMm), ball.height_mm, ball.height_sigma_mm});
  }
  if (seen_.empty()) return;
  if (!ball_ || seen_.front().t_s - ball_->seen_s() > kBallGone_s) {
    look_for_ball(seen_);
    return;
  }
  ball_->add(seen_, robots_);
  const auto& kick = ball_->kick();
  if (!kick) return;
  if (kick->number != kick_of_ball_) {
    kick_of_ball_ = kick->number;
    ++kicks_;
  }
  kick_ = kick;
  kick_->number = kicks_;
}

/// Three sightings that one ball on its way may be.
void Tracker::look_for_ball(const std::vector<BallTrack::Sighting>& seen) {
  constexpr double kLately_s = 0.1, kFastest_mm_s = 7000, kNearMm = 3, kStraightMm = 8;
  const double t_s = seen.front().t_s;
  std::erase_if(lately_, [&](const auto& one) { return one.t_s < t_s - kLately_s; });
  for (const BallTrack::Sighting& now : seen) {
    std::vector<const BallTrack::Sighting*> before;
    for (const BallTrack::Sighting& one : lately_) {
      const double passed_s = now.t_s - one.t_s;
      if (passed_s > 1e-3 && (one.place_mm - now.place_mm).norm() < kFastest_mm_s * passed_s + kNearMm)
        before.push_back(&one);
    }
    constexpr std::size_t kEnough = 3;
    if (before.size() < kEnough) continue;
    const BallTrack::Sighting &first = *before.front(), &middle = *before[before.size() / 2];
    const Vector2d velocity = (now.place_mm - first.place_mm) / (now.t_s - first.t_s);
    if ((first.place_mm + velocity * (middle.t_s - first.t_s) - middle.place_mm).norm() >= kStraightMm)
      continue;
    ball_.emplace(model_, now, velocity);
    kick_of_ball_ = 0;
    lately_.clear();
    return;
  }
  lately_.insert(lately_.end(), seen.begin(), seen.end());
}

std::optional<TrackedBall> Tracker::ball(double t_s) const {
  if (!ball_ || t_s - ball_->seen_s() > kBallGone_s) return {};
  return ball_->at(t_s, robots_);
}

}  // namespace sslv
