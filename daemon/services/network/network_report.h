// SPDX-License-Identifier: Apache-2.0
#pragma once

// Alerts and checks of what is sent and heard.

#include "config/config.h"
#include "net/multicast.h"
#include "net/other_visions.h"
#include "net/packets.h"
#include "net/referee_listener.h"
#include "services/health_report.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace sslv {

/// What is wrong with the network card that packets leave by; names of cards, empty: nothing.
struct CardsUsed {
  std::string unused;        // one that other computers may be on, while packets go to this computer only
  std::string without_link;  // the one that packets go to, with its cable pulled out
};

/// What is known of the network, read once, so that alerts, checks and figures agree.
struct NetworkFacts {
  std::shared_ptr<const Config> config;
  MulticastStatus multicast;
  std::shared_ptr<const Geometry> geometry;  // what is sent
  std::vector<OtherVision> other_visions;
  bool another_host_sends = false;  // one of them is on another computer that the settings name
  CardsUsed cards{};
  std::string listening_error;        // why the vision group cannot be heard
  std::uint64_t refused_packets = 0;  // that came to the vision group
  RefereeStatus referee;
};

/// The sizes of the field that another vision tells otherwise.
std::vector<SizeConflict> field_conflicts(const NetworkFacts& facts, const OtherVision& other);

/// Adds their alerts and the checks "network", "other_visions", "referee" and "teams".
void report_network(const NetworkFacts& facts, HealthReport& report);

/// docs/openapi.json's Status: "network", "referee" and "teams".
void add_network_status(const NetworkFacts& facts, Json& status);

}  // namespace sslv
