// SPDX-License-Identifier: Apache-2.0
#include "net/heard_cameras.h"

#include "ssl_vision_wrapper.pb.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace sslv {
namespace {

/// More can only be an attack.
constexpr std::size_t kMaxCameras = 64, kMaxOfAKind = 64;
constexpr std::uint32_t kMaxId = 255;   // as in our own settings
constexpr double kRobotHeightMm = 140;  // where a packet does not say it

void add_robots(const google::protobuf::RepeatedPtrField<SSL_DetectionRobot>& robots, Team team,
                CameraSightings& out) {
  for (const SSL_DetectionRobot& robot : robots) {
    if (out.robots.size() >= 2 * kMaxOfAKind) return;
    if (!robot.has_robot_id() || !robot.has_orientation() || robot.robot_id() > 255) continue;
    out.robots.push_back({team,
                          static_cast<int>(robot.robot_id()),
                          {robot.x(), robot.y()},
                          robot.orientation(),
                          robot.has_height() ? static_cast<double>(robot.height()) : kRobotHeightMm,
                          Eigen::Matrix2d::Zero(),
                          0});
  }
}

}  // namespace

void OtherClock::heard(double t_sent_s, double t_heard_s) {
  constexpr double kStretch_s = 5;
  const double way_s = t_heard_s - t_sent_s;
  if (!has_now_ || t_heard_s - since_s_ > kStretch_s || t_heard_s < since_s_) {
    has_before_ = has_now_ && t_heard_s >= since_s_;
    least_before_s_ = least_now_s_;
    least_now_s_ = way_s;
    since_s_ = t_heard_s;
    has_now_ = true;
    return;
  }
  least_now_s_ = std::min(least_now_s_, way_s);
}

double OtherClock::correction_s() const {
  if (!has_now_) return 0;
  const double least_s = has_before_ ? std::min(least_before_s_, least_now_s_) : least_now_s_;
  // Synchronised clocks differ by less, and so do ways.
  constexpr double kRight_s = 3e-3, kWay_s = 0.2e-3;
  return std::abs(least_s) < kRight_s ? 0 : least_s - kWay_s;
}

bool HeardCameras::read(const SSL_WrapperPacket& packet, const std::string& address, double now_s,
                        double unix_s, CameraSightings& out) {
  for (const SSL_GeometryCameraCalibration& camera : packet.geometry().calib()) {
    const Key key{address, static_cast<int>(camera.camera_id())};
    if (places_mm_.size() >= kMaxCameras && !places_mm_.contains(key)) continue;
    if (!camera.has_derived_camera_world_tz() || camera.camera_id() > kMaxId) continue;
    places_mm_[key] = {camera.derived_camera_world_tx(), camera.derived_camera_world_ty(),
                       camera.derived_camera_world_tz()};
  }
  if (!packet.has_detection()) return false;
  const SSL_DetectionFrame& frame = packet.detection();
  const Key key{address, static_cast<int>(frame.camera_id())};
  const auto place = places_mm_.find(key);
  if (place == places_mm_.end()) return false;  // not calibrated, or its geometry has not come yet
  std::erase_if(holders_, [&](const auto& one) { return now_s - one.second.heard_s > kForgottenAfter_s; });
  const auto holder = holders_.find(key.second);
  const bool is_own = own_.contains(key.second);
  if (is_own || (holder != holders_.end() && holder->second.address != address)) {
    if (conflicts_.size() < kMaxCameras || conflicts_.contains(key))
      conflicts_[key] = {now_s, {key.second, address, is_own ? "" : holder->second.address}};
    return false;
  }
  if (holder == holders_.end() && holders_.size() >= kMaxCameras) return false;
  Holder& from = holders_[key.second];
  from.address = address;
  from.heard_s = now_s;
  if (std::isfinite(frame.t_sent())) from.clock.heard(frame.t_sent(), unix_s);

  out.camera = key.second;
  out.frame_number = frame.frame_number();
  out.t_capture_s = frame.t_capture() + from.clock.correction_s();
  out.camera_mm = place->second;
  out.is_of_other_computer = true;
  out.robots.clear();
  add_robots(frame.robots_yellow(), Team::kYellow, out);
  add_robots(frame.robots_blue(), Team::kBlue, out);
  out.balls.clear();
  for (const SSL_DetectionBall& ball : frame.balls()) {
    if (out.balls.size() >= kMaxOfAKind) break;
    out.balls.push_back({{ball.x(), ball.y()}, Eigen::Matrix2d::Zero(), ball.confidence()});
  }
  return true;
}

std::vector<HeardCameras::Conflict> HeardCameras::conflicts(double now_s) const {
  std::vector<Conflict> out;
  for (const auto& [key, heard] : conflicts_) {
    if (now_s - heard.first <= kForgottenAfter_s) out.push_back(heard.second);
  }
  return out;
}

std::map<int, HeardCameras::Heard> HeardCameras::cameras(double now_s) const {
  std::map<int, Heard> out;
  for (const auto& [id, holder] : holders_) {
    if (now_s - holder.heard_s <= kForgottenAfter_s) out[id] = {holder.address, holder.clock.correction_s()};
  }
  return out;
}

}  // namespace sslv
