// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "recording/match_log_format.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sslv {

/// Whether a datagram is what programs of the league send to the group of that type of message. Others can
/// send what they like there, and a match log is not to be filled with it.
bool is_league_message(std::int32_t type, std::span<const std::byte> datagram);

/// Limits what a match log takes of a group: more bytes than any field sends, but fewer than a network can.
/// No sender gets more than half of them. What a second leaves is added to the next one's share.
class LeagueShare {
 public:
  explicit LeagueShare(double bytes_per_s) : bytes_per_s_(bytes_per_s), all_{0, 2 * bytes_per_s, 0} {}

  /// False: a datagram of so many bytes is too much. Its header in the log counts, too. `sender`: IPv4
  /// address; `now_s`: on a steady clock.
  bool take(std::uint32_t sender, std::size_t bytes, double now_s);

 private:
  struct Bucket {
    std::uint32_t sender = 0;
    double left_bytes = 0, at_s = 0;
  };
  /// Those heard last; a new one replaces the one that has been silent for longest.
  static constexpr std::size_t kMaxSenders = 64;
  Bucket& bucket_of(std::uint32_t sender, double now_s);

  const double bytes_per_s_;
  Bucket all_;
  std::vector<Bucket> senders_;
};

/// Two visions with four large cameras each send 2 MB/s, three trackers 2 MB/s, a game controller 100 kB/s.
inline constexpr double kVisionShare_bytes_per_s = 4e6, kTrackerShare_bytes_per_s = 4e6,
                        kRefereeShare_bytes_per_s = 1e6;

}  // namespace sslv
