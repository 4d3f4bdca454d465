// SPDX-License-Identifier: Apache-2.0
#include "net/heard_cameras.h"

#include "geometry/limits.h"
#include "pipeline/validate.h"

#include <algorithm>
#include <cmath>

namespace sslv {

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
  // Synchronised clocks differ by less than kRight_s. kWay_s is a typical transmission time.
  constexpr double kRight_s = 3e-3, kWay_s = 0.2e-3;
  return std::abs(least_s) < kRight_s ? 0 : least_s - kWay_s;
}

void HeardCameras::forget(double now_s) {
  std::erase_if(places_,
                [&](const auto& one) { return now_s - one.second.heard_s > kPlaceForgottenAfter_s; });
  std::erase_if(holders_, [&](const auto& one) { return now_s - one.second.heard_s > kForgottenAfter_s; });
  std::erase_if(without_place_,
                [&](const auto& one) { return now_s - one.second.heard_s > kForgottenAfter_s; });
  std::erase_if(conflicts_, [&](const auto& one) { return now_s - one.second.first > kForgottenAfter_s; });
}

void HeardCameras::note_places(const VisionMessage& message, const std::string& address, bool is_named,
                               double now_s) {
  // Cameras of unnamed computers have their own limit, so that they take no space from cameras of named
  // computers. The latter are limited by their ids.
  auto unnamed = static_cast<std::size_t>(
      std::ranges::count_if(places_, [](const auto& one) { return !one.second.is_named; }));
  for (const VisionMessage::Camera& camera : message.cameras) {
    const Key key{address, camera.id};
    const bool is_new = !places_.contains(key);
    if (is_new && !is_named && unnamed++ >= limits::kMaxUnnamedCameras) continue;
    places_[key] = {camera.place_mm, now_s, is_named};
  }
}

bool HeardCameras::hear(const VisionMessage& message, const std::string& address, bool is_named, double now_s,
                        double unix_s, ArrivedSightings& out) {
  forget(now_s);
  note_places(message, address, is_named, now_s);
  if (message.field || !message.cameras.empty()) {
    for (auto& [key, wait] : without_place_) wait.geometry_came |= key.first == address;
  }
  if (!message.detection) return false;
  const CameraSightings& image = message.detection->arrived.image;
  const Key key{address, image.camera};
  const auto place = places_.find(key);
  if (place == places_.end()) {  // not calibrated, or its geometry was not received yet
    if (is_named && !own_.contains(image.camera))
      without_place_.try_emplace(key, Wait{now_s, now_s}).first->second.heard_s = now_s;
    return false;
  }
  without_place_.erase(key);
  place->second.heard_s = now_s;
  place->second.is_named = is_named;
  if (own_.contains(image.camera)) {
    holders_.erase(image.camera);
    return false;
  }
  Holder& holder = holders_[image.camera];
  const Heard& newest = holder.newest;
  if (!newest.address.empty() && newest.address != address && (newest.is_used || !is_named)) {
    if (newest.is_used) conflicts_[key] = {now_s, {image.camera, address, newest.address}};
    return false;
  }
  if (newest.address != address) holder = {};
  holder.heard_s = now_s;
  holder.clock.heard(message.detection->t_sent_s, unix_s);
  holder.newest = {address, is_named, holder.clock.correction_s(), image.robots.size(), image.balls.size()};
  if (!is_named) return false;

  out = message.detection->arrived;
  out.image.t_capture_s += newest.clock_correction_s;
  out.image.camera_mm = place->second.mm;
  const InvalidCounts dropped = drop_invalid(out.image);  // again, now that the camera's height is known
  out.left_out += dropped.robots + dropped.balls;
  return true;
}

std::vector<HeardCameras::Conflict> HeardCameras::conflicts(double now_s) const {
  std::vector<Conflict> out;
  for (const bool is_named : {true, false}) {
    for (const auto& [key, heard] : conflicts_) {
      if (now_s - heard.first <= kForgottenAfter_s && places_.at(key).is_named == is_named)
        out.push_back(heard.second);
    }
  }
  return out;
}

std::vector<HeardCameras::Uncalibrated> HeardCameras::uncalibrated(double now_s) const {
  std::vector<Uncalibrated> out;
  for (const auto& [key, wait] : without_place_) {
    if (now_s - wait.heard_s <= kForgottenAfter_s &&
        (wait.geometry_came || now_s - wait.since_s > kPlaceForgottenAfter_s))
      out.push_back({key.second, key.first});
  }
  return out;
}

std::map<int, HeardCameras::Heard> HeardCameras::cameras(double now_s) const {
  std::map<int, Heard> out;
  for (const auto& [id, holder] : holders_) {
    if (now_s - holder.heard_s <= kForgottenAfter_s) out[id] = holder.newest;
  }
  return out;
}

}  // namespace sslv
