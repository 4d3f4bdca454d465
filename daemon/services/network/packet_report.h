// SPDX-License-Identifier: Apache-2.0
#pragma once

// JSON of the packets that teams receive, and of the listeners that this computer knows of.

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
  std::vector<Arrival> vision, referee;  // senders whose packets arrive, and how
  std::string broadcast_error;  // why broadcasts to the vision or the game controller are not received
};

/// SentPackets of docs/openapi.json. `now_s`: monotonic.
Json packets_json(const PacketFacts& facts, double now_s);

/// Listeners of docs/openapi.json. Reads /proc and the user database.
Json listeners_json(const MulticastSettings& vision);

}  // namespace sslv
