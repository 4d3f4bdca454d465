// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "recording/match_log_format.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sslv {

/// Whether a datagram is a valid message of that type. Any program can send to the multicast groups, and a
/// match log must not be filled with other data.
bool is_league_message(std::int32_t type, std::span<const std::byte> datagram);

/// Rate limit for the datagrams of a group in a match log: a token bucket for the group, and one at half the
/// rate for each sender. Each bucket holds 2 s of its rate.
class LeagueShare {
 public:
  explicit LeagueShare(double bytes_per_s) : bytes_per_s_(bytes_per_s), all_{0, 2 * bytes_per_s, 0} {}

  /// Consumes the datagram's bytes and its header in the log; false, consuming nothing, if that exceeds a
  /// limit. `sender`: IPv4 address; `now_s`: on a steady clock.
  bool take(std::uint32_t sender, std::size_t bytes, double now_s);

 private:
  struct Bucket {
    std::uint32_t sender = 0;
    double left_bytes = 0, at_s = 0;
  };
  /// A further sender replaces the one that has been silent for longest.
  static constexpr std::size_t kMaxSenders = 64;
  Bucket& bucket_of(std::uint32_t sender, double now_s);

  const double bytes_per_s_;
  Bucket all_;
  std::vector<Bucket> senders_;
};

/// Higher rates than on any field, but lower than a network's. For comparison: two visions that each have
/// four large cameras send 2 MB/s, three trackers send 2 MB/s, and a game controller sends 100 kB/s.
inline constexpr double kVisionShare_bytes_per_s = 4e6, kTrackerShare_bytes_per_s = 4e6,
                        kRefereeShare_bytes_per_s = 1e6;

}  // namespace sslv
