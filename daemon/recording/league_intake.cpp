// SPDX-License-Identifier: Apache-2.0
#include "recording/league_intake.h"

#include "net/parse.h"
#include "ssl_gc_referee_message.pb.h"
#include "ssl_vision_wrapper.pb.h"
#include "ssl_vision_wrapper_tracked.pb.h"

#include <algorithm>

namespace sslv {

bool is_league_message(std::int32_t type, std::span<const std::byte> datagram) {
  switch (type) {
    case LoggedMessage::kVision2014: {
      thread_local SSL_WrapperPacket packet;
      return parse(packet, datagram) && (packet.has_detection() || packet.has_geometry());
    }
    case LoggedMessage::kTracker2020: {
      thread_local TrackerWrapperPacket packet;
      return parse(packet, datagram) && packet.has_tracked_frame();
    }
    case LoggedMessage::kReferee: {
      thread_local Referee packet;
      return parse(packet, datagram) && packet.yellow().has_name() && packet.blue().has_name();
    }
    default: return false;
  }
}

bool LeagueShare::take(std::size_t bytes, double now_s) {
  left_bytes_ = std::min(2 * bytes_per_s_, left_bytes_ + bytes_per_s_ * std::max(0.0, now_s - at_s_));
  at_s_ = now_s;
  const double counted = static_cast<double>(bytes + kMessageHeaderBytes);
  if (counted > left_bytes_) return false;
  left_bytes_ -= counted;
  return true;
}

}  // namespace sslv
