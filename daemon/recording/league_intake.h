// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "recording/match_log_format.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace sslv {

/// Whether a datagram is what the league sends to the group of that type of message. Others can send what
/// they like there; a match log is not to be filled with it.
bool is_league_message(std::int32_t type, std::span<const std::byte> datagram);

/// How much of a group's datagrams a match log takes: more than any field sends, but not all that somebody
/// can send. What is left of a second's share is kept for the next one.
class LeagueShare {
 public:
  explicit LeagueShare(double bytes_per_s) : bytes_per_s_(bytes_per_s), left_bytes_(2 * bytes_per_s) {}

  /// Of a datagram of so many bytes, counted with its header in the log. `now_s`: on a steady clock. False:
  /// it is more than the share.
  bool take(std::size_t bytes, double now_s);

 private:
  double bytes_per_s_, left_bytes_;
  double at_s_ = 0;
};

/// Four large cameras of two visions send 2 MB/s, three trackers 2 MB/s, a game controller 100 kB/s.
inline constexpr double kVisionShare_bytes_per_s = 4e6, kTrackerShare_bytes_per_s = 4e6,
                        kRefereeShare_bytes_per_s = 1e6;

}  // namespace sslv
