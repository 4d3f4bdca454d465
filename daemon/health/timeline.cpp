// SPDX-License-Identifier: Apache-2.0
#include "health/timeline.h"

#include <algorithm>
#include <cmath>

namespace sslv {
namespace {

constexpr double kClockWasSet_s = 0.5;

/// Increase of a counter, which restarts with the camera.
std::uint64_t passed(std::uint64_t before, std::uint64_t now) {
  return now >= before ? now - before : now;
}

std::optional<Timeline::Reading> second_between(const Timeline::Reading& before, Timeline::Reading now) {
  if (!before.is_running || !now.is_running) return std::nullopt;
  now.frames = passed(before.frames, now.frames);
  now.dropped = passed(before.dropped, now.dropped);
  now.incomplete = passed(before.incomplete, now.incomplete);
  now.capped = passed(before.capped, now.capped);
  return now;
}

}  // namespace

void Timeline::add(double unix_time_s, double steady_s, const std::map<int, Reading>& cameras) {
  const std::lock_guard lock(mutex_);
  std::erase_if(cameras_, [&](const auto& one) { return !cameras.contains(one.first); });
  for (const auto& [id, reading] : cameras) {
    const auto [place, is_new] = cameras_.try_emplace(id);
    Camera& camera = place->second;
    if (is_new) camera.seconds.resize(times_s_.size());
    camera.seconds.push_back(is_new ? std::nullopt : second_between(camera.last, reading));
    camera.last = reading;
    if (camera.seconds.size() > kSeconds) camera.seconds.pop_front();
  }
  // A second keeps its time unless the clock was set: viewers identify seconds by their time.
  if (std::abs(unix_time_s - steady_s - ahead_s_) > kClockWasSet_s) ahead_s_ = unix_time_s - steady_s;
  times_s_.push_back(steady_s);
  if (times_s_.size() > kSeconds) times_s_.pop_front();
}

void Timeline::forget(int camera_id) {
  const std::lock_guard lock(mutex_);
  cameras_.erase(camera_id);
}

Timeline::Sum Timeline::sum(int camera_id, std::size_t seconds) const {
  Sum sum;
  const std::lock_guard lock(mutex_);
  const auto found = cameras_.find(camera_id);
  if (found == cameras_.end()) return sum;
  const auto& all = found->second.seconds;
  for (std::size_t i = all.size() - std::min(all.size(), seconds); i < all.size(); ++i) {
    if (!all[i]) continue;
    ++sum.seconds;
    sum.frames += all[i]->frames;
    sum.dropped += all[i]->dropped;
    sum.incomplete += all[i]->incomplete;
    sum.capped += all[i]->capped;
  }
  return sum;
}

Json Timeline::to_json(std::size_t seconds) const {
  const std::lock_guard lock(mutex_);
  const std::size_t first = times_s_.size() - std::min(times_s_.size(), seconds);
  Json out{{"interval_s", 1}, {"time_s", Json::array()}, {"cameras", Json::array()}};
  for (std::size_t i = first; i < times_s_.size(); ++i) out["time_s"].push_back(times_s_[i] + ahead_s_);
  for (const auto& [id, camera] : cameras_) {
    Json one{{"id", id}};
    const auto add = [&, &seconds_of = camera.seconds](const char* name, auto value_of) {
      Json values = Json::array();
      for (std::size_t i = first; i < seconds_of.size(); ++i)
        values.push_back(seconds_of[i] ? Json(value_of(*seconds_of[i])) : Json(nullptr));
      one[name] = std::move(values);
    };
    const auto time = [](double Reading::Times::*member) {
      return [member](const Reading& r) { return r.times ? Json((*r.times).*member) : Json(nullptr); };
    };
    add("fps", [](const Reading& r) { return r.fps; });
    add("latency_p50_ms", time(&Reading::Times::latency_p50_ms));
    add("latency_p99_ms", time(&Reading::Times::latency_p99_ms));
    add("age_p99_ms", time(&Reading::Times::age_p99_ms));
    add("robots", [](const Reading& r) { return r.robots; });
    add("balls", [](const Reading& r) { return r.balls; });
    add("dropped", [](const Reading& r) { return r.dropped; });
    add("incomplete", [](const Reading& r) { return r.incomplete; });
    add("capped", [](const Reading& r) { return r.capped; });
    out["cameras"].push_back(std::move(one));
  }
  return out;
}

}  // namespace sslv
