// SPDX-License-Identifier: Apache-2.0
#pragma once

// What teams get, and who listens as far as this computer knows.

#include "base/json.h"
#include "net/heard_packets.h"
#include "net/multicast.h"
#include "net/multicast_receiver.h"

#include <string>
#include <vector>

namespace sslv {

struct PacketFacts {
  MulticastSettings sent_by;
  const HeardPackets& heard;
  std::string listening_error;
  std::vector<Arrival> vision, referee;  // who is heard, and which way
  std::string broadcast_error;           // why broadcasts to the vision or the game controller are not
};

/// docs/openapi.json's SentPackets, at a monotonic time.
Json packets_json(const PacketFacts& facts, double now_s);

/// docs/openapi.json's Listeners. Reads /proc and the user database.
Json listeners_json(const MulticastSettings& vision);

}  // namespace sslv
