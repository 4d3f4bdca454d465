// SPDX-License-Identifier: Apache-2.0
#include "services/calibration/tie_collector.h"

#include <algorithm>
#include <cmath>

namespace sslv {
namespace {

/// Assumed standard deviation between the cameras' clocks. It makes tie points of moving robots less
/// accurate.
constexpr double kClockSigmaS = 1e-3;
/// Longest interval between two images to interpolate over, for slow cameras and busy computers. An
/// acceleration moves a robot off the interpolated straight line, which makes its tie point less accurate.
constexpr double kMaxGapS = 0.15, kAccelerationMmS2 = 3000;
/// Larger than any calibration error: detections farther apart are two robots with the same id.
constexpr double kOtherRobotMm = 300;
constexpr double kCellMm = 250;
constexpr std::size_t kMaxTies = 100;

}  // namespace

void TieCollector::add(std::size_t camera, double t_capture_s, std::span<const Robot> robots) {
  for (const Robot& robot : robots) {
    auto& tracks = tracks_[{robot.team, robot.id}];
    tracks.resize(cameras_);
    Track& track = tracks[camera];
    if (track.newest && track.newest->t_s == t_capture_s) continue;   // a second robot with this id
    if (track.newest && track.newest->t_s > t_capture_s) track = {};  // the clock was set back
    track.before = track.newest;
    track.newest = {t_capture_s, {robot.pixel_x, robot.pixel_y}, {robot.x_mm, robot.y_mm}, robot.height_mm};
    for (std::size_t other = 0; other < cameras_; ++other) {
      if (other == camera) continue;
      // Images of either camera may arrive later, so each camera's detections are compared with interpolated
      // positions of the other camera.
      tie(camera, *track.newest, other, tracks[other]);
      if (tracks[other].newest) tie(other, *tracks[other].newest, camera, track);
      if (tracks[other].before) tie(other, *tracks[other].before, camera, track);
    }
  }
}

void TieCollector::tie(std::size_t camera, const Seen& seen, std::size_t other_camera, const Track& other) {
  if (!other.before) return;
  const Seen &from = *other.before, &to = *other.newest;
  const double gap_s = to.t_s - from.t_s;
  if (seen.t_s < from.t_s || seen.t_s > to.t_s || gap_s > kMaxGapS) return;
  if (from.height_mm != seen.height_mm || to.height_mm != seen.height_mm) return;
  const double share = (seen.t_s - from.t_s) / gap_s;
  const Eigen::Vector2d pixel = from.pixel + share * (to.pixel - from.pixel);
  const Eigen::Vector2d place_mm = from.place_mm + share * (to.place_mm - from.place_mm);
  if ((place_mm - seen.place_mm).norm() > kOtherRobotMm) return;

  OverlapTie found{camera, other_camera, seen.pixel, pixel, seen.height_mm};
  const double moved_px = (to.pixel - from.pixel).norm(), moved_mm = (to.place_mm - from.place_mm).norm();
  const double off_mm = std::min(kAccelerationMmS2 * gap_s * gap_s / 8, moved_mm / 2);
  const double off_px = moved_mm > 0 ? off_mm * moved_px / moved_mm : 0;
  found.sigma_px = std::hypot(found.sigma_px, kClockSigmaS * moved_px / gap_s, off_px);
  const Cell cell{std::min(camera, other_camera), std::max(camera, other_camera),
                  static_cast<int>(std::floor(seen.place_mm.x() / kCellMm)),
                  static_cast<int>(std::floor(seen.place_mm.y() / kCellMm))};
  const auto [kept, is_new] = ties_.try_emplace(cell, found);
  if (!is_new && found.sigma_px < kept->second.sigma_px) kept->second = found;
}

std::vector<OverlapTie> TieCollector::ties() const {
  std::vector<OverlapTie> out;
  // The map sorts cells by position, so taking every n-th tie point keeps the covered area.
  const std::size_t step = (ties_.size() + kMaxTies - 1) / kMaxTies;
  std::size_t i = 0;
  for (const auto& [cell, tie] : ties_) {
    if (i++ % step == 0) out.push_back(tie);
  }
  return out;
}

}  // namespace sslv
