// SPDX-License-Identifier: Apache-2.0
#include "services/network/packet_timeline.h"

#include <algorithm>

namespace sslv {

void PacketTimeline::add(double unix_time_s, std::uint64_t packets_sent) {
  const std::lock_guard lock(mutex_);
  const double passed_s = unix_time_s - last_s_;
  // If the clock was set in between, the duration is unknown.
  constexpr double kLongest_s = 10;
  if (last_s_ > 0 && passed_s > 0 && passed_s < kLongest_s)
    seconds_.push_back({unix_time_s, static_cast<double>(packets_sent - last_sent_) / passed_s});
  if (seconds_.size() > kSeconds) seconds_.pop_front();
  last_s_ = unix_time_s;
  last_sent_ = packets_sent;
}

Json PacketTimeline::to_json(std::size_t seconds) const {
  Json out{{"time_s", Json::array()}, {"packets_per_s", Json::array()}};
  const std::lock_guard lock(mutex_);
  for (std::size_t i = seconds_.size() - std::min(seconds_.size(), seconds); i < seconds_.size(); ++i) {
    out["time_s"].push_back(seconds_[i].time_s);
    out["packets_per_s"].push_back(seconds_[i].packets_per_s);
  }
  return out;
}

}  // namespace sslv
