// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/snapshot.h"
#include "config/config.h"
#include "net/heard_packets.h"
#include "net/multicast.h"
#include "net/network_cards.h"
#include "net/other_visions.h"
#include "net/packets.h"
#include "net/referee_listener.h"
#include "net/vision_sender.h"
#include "services/network/network_report.h"
#include "services/network/packet_timeline.h"
#include "services/service.h"

#include <atomic>
#include <functional>
#include <string>
#include <vector>

namespace sslv {

/// Sends geometry to the teams, and listens on the field's network.
class NetworkService final : public Service {
 public:
  /// `multicast`, which also sends the detections, and `config` must outlive this.
  NetworkService(const Snapshot<Config>& config, MulticastSender& multicast);

  const RefereeListener& referee() const { return referee_; }
  /// `act` is called from the referee's thread whenever a team's name changes. Set it before the first change
  /// of settings is applied.
  void on_new_team_names(std::function<void()> act) { on_new_names_ = std::move(act); }
  /// `act` is called from the listening thread with the messages of other visions. Set it before the first
  /// change of settings is applied.
  void on_other_vision(OtherVisions::OnOther act) { on_other_ = std::move(act); }
  /// Stops receiving, so that neither callback is called any more.
  void stop_listening();

  Plan plan(const SettingsChange& change) const override;
  std::vector<Route> routes() override;
  void report(HealthReport& report) const override;
  void write_metrics(MetricsText& out) const override;
  void each_second() override;

  /// "224.5.23.2:10006", with a note if packets do not leave.
  std::string summary() const;
  /// One line for each problem with sending packets; empty if packets leave to all destinations.
  std::string missing() const;

 private:
  NetworkFacts facts() const;
  std::string broadcast_error() const;
  /// Computers of the field on other cards, if none is heard on the card in use.
  std::vector<HeardOn> heard_elsewhere(const Config& config, const std::vector<NetworkCard>& cards) const;

  const Snapshot<Config>& config_;
  MulticastSender& multicast_;
  Snapshot<Geometry> geometry_;
  GeometrySender geometry_sender_;
  std::function<void()> on_new_names_;
  OtherVisions::OnOther on_other_ = [](const VisionMessage&, const std::string&, bool, double) {};
  RefereeListener referee_;
  GroupAddress heard_at_;       // used by the thread that applies settings
  HeardPackets heard_packets_;  // before other_visions_, whose thread fills it
  OtherVisions other_visions_;
  PacketTimeline packet_timeline_;
  // Updated once a second, because this queries the system for the computer's addresses.
  std::atomic<bool> another_host_sends_ = false;
  Snapshot<CardsUsed> cards_used_{CardsUsed{}};
};

}  // namespace sslv
