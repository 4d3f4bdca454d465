// SPDX-License-Identifier: Apache-2.0
#pragma once

// Alerts and checks of the packets that are sent and received.

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

/// Names of network cards with a problem; empty: no problem.
struct CardsUsed {
  std::string sender{};        // the card that sends the packets, and its address: "eth0 (10.0.0.2)"
  std::string others{};        // if the settings choose no card: other cards with a link
  std::string heard_on{};      // a card with computers of the field, if none is heard on the sending card
  std::string heard{};         // one of these computers
  std::string unused{};        // a card with a link, although packets reach only this computer
  std::string without_link{};  // the card that sends the packets, if its cable is unplugged
};

/// Facts about the network, read once so that alerts, checks and figures agree.
struct NetworkFacts {
  std::shared_ptr<const Config> config;
  MulticastStatus multicast;
  std::shared_ptr<const Geometry> geometry;  // geometry that is sent
  std::vector<OtherVision> other_visions;
  bool another_host_sends = false;  // one of other_visions is on another computer named in the settings
  CardsUsed cards{};
  std::string listening_error;        // why the vision group cannot be received; empty: it can
  std::uint64_t refused_packets = 0;  // invalid packets received in the vision group
  RefereeStatus referee;
};

/// Returns the field sizes that differ between this service and another vision.
std::vector<SizeConflict> field_conflicts(const NetworkFacts& facts, const OtherVision& other);

/// Adds alerts and the checks "network", "other_visions", "referee" and "teams".
void report_network(const NetworkFacts& facts, HealthReport& report);

/// "network", "referee" and "teams" of docs/openapi.json's Status.
void add_network_status(const NetworkFacts& facts, Json& status);

}  // namespace sslv
