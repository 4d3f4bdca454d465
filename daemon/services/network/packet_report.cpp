// SPDX-License-Identifier: Apache-2.0
#include "services/network/packet_report.h"

#include "net/local_listeners.h"

#include <algorithm>
#include <utility>

namespace sslv {
namespace {

Json packet_figures(const HeardPacket& packet, double now_s) {
  return {{"bytes", packet.bytes.size()},
          {"packets", packet.count},
          {"packets_per_s", packet.per_s},
          {"age_s", std::max(0.0, now_s - packet.heard_s)},
          {"packet", parse_own_json(packet_json(packet.bytes))}};
}

/// Why packets that were sent may be missing from the answer; empty if none are missing.
std::string not_heard_because(const PacketFacts& facts) {
  if (!facts.listening_error.empty()) return facts.listening_error;
  const bool is_broadcast = !facts.sent_by.broadcast.empty() ||
                            !boost::asio::ip::make_address_v4(facts.sent_by.group).is_multicast();
  if (!facts.sent_by.loopback && !is_broadcast) {
    return "/network/vision/loopback is off, so no program on this computer receives the packets, not even "
           "this service; teams still get them";
  }
  return "";
}

void add_arrivals(const char* what, const std::vector<Arrival>& arrivals, Json& out) {
  for (const Arrival& one : arrivals) {
    out.push_back({{"what", what},
                   {"address", one.address},
                   {"multicast", one.by_multicast},
                   {"broadcast", one.by_broadcast}});
  }
}

}  // namespace

Json packets_json(const PacketFacts& facts, double now_s) {
  Json detections = Json::array();
  for (const auto& [id, packet] : facts.heard.detections(now_s)) {
    Json one{{"camera", id}};
    one.update(packet_figures(packet, now_s));
    detections.push_back(std::move(one));
  }
  const auto geometry = facts.heard.geometry(now_s);
  Json arrivals = Json::array();
  add_arrivals("vision", facts.vision, arrivals);
  add_arrivals("game controller", facts.referee, arrivals);
  return {{"group", facts.sent_by.group},
          {"port", facts.sent_by.port},
          {"broadcast", facts.sent_by.broadcast},
          {"arrivals", std::move(arrivals)},
          {"broadcasts_not_heard_because", facts.broadcast_error},
          {"not_heard_because", not_heard_because(facts)},
          {"detections", std::move(detections)},
          {"geometry", geometry ? packet_figures(*geometry, now_s) : Json(nullptr)}};
}

Json listeners_json(const MulticastSettings& vision) {
  const LocalListeners found = local_listeners(boost::asio::ip::make_address_v4(vision.group), vision.port);
  Json programs = Json::array(), cards = Json::array();
  for (const ListeningSocket& socket : found.others) {
    programs.push_back({{"user", user_name(socket.user_id)}, {"address", socket.address}});
  }
  for (const GroupMembership& card : found.memberships) {
    cards.push_back(
        {{"interface", card.interface}, {"joins", card.joins}, {"igmp_version", card.igmp_version}});
  }
  return {{"group", vision.group},
          {"port", vision.port},
          {"programs", std::move(programs)},
          {"memberships", std::move(cards)}};
}

}  // namespace sslv
