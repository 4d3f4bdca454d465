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
      // Length-delimited field 4: a Vision Processor's own settings.
      constexpr std::byte kProcessorSettings{4 << 3 | 2};
      thread_local SSL_WrapperPacket packet;
      return parse(packet, datagram) && (packet.has_detection() || packet.has_geometry() ||
                                         (!datagram.empty() && datagram[0] == kProcessorSettings));
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

LeagueShare::Bucket& LeagueShare::bucket_of(std::uint32_t sender, double now_s) {
  const auto found = std::ranges::find(senders_, sender, &Bucket::sender);
  if (found != senders_.end()) return *found;
  const Bucket full{sender, bytes_per_s_, now_s};
  if (senders_.size() < kMaxSenders) return senders_.emplace_back(full);
  return *std::ranges::min_element(senders_, {}, &Bucket::at_s) = full;
}

bool LeagueShare::take(std::uint32_t sender, std::size_t bytes, double now_s) {
  const auto refill = [now_s](Bucket& bucket, double bytes_per_s) {
    const double more = bytes_per_s * std::max(0.0, now_s - bucket.at_s);
    bucket.left_bytes = std::min(2 * bytes_per_s, bucket.left_bytes + more);
    bucket.at_s = std::max(bucket.at_s, now_s);  // a clock set back and forward again adds nothing
  };
  Bucket& own = bucket_of(sender, now_s);
  refill(own, bytes_per_s_ / 2);
  refill(all_, bytes_per_s_);
  const auto counted = static_cast<double>(bytes + kMessageHeaderBytes);
  if (counted > std::min(own.left_bytes, all_.left_bytes)) return false;
  own.left_bytes -= counted;
  all_.left_bytes -= counted;
  return true;
}

}  // namespace sslv
