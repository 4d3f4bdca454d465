// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/snapshot.h"
#include "config/config.h"
#include "net/heard_packets.h"
#include "net/multicast.h"
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

namespace sslv {

/// What goes out to the teams besides detections, and what is heard on the field's network.
class NetworkService final : public Service {
 public:
  /// `multicast`, which detections leave by too, and `config` must outlive this.
  NetworkService(const Snapshot<Config>& config, MulticastSender& multicast);

  const RefereeListener& referee() const { return referee_; }
  /// Called from the referee's thread whenever a team has another name. To be set before the first change of
  /// settings is applied.
  void on_new_team_names(std::function<void()> act) { on_new_names_ = std::move(act); }
  /// Likewise: `act` is called with what another vision says, from the thread that listens.
  void on_other_vision(OtherVisions::OnOther act) { on_other_ = std::move(act); }
  /// Nothing is heard any more, so that nobody is told of new names.
  void stop_listening();

  Plan plan(const SettingsChange& change) const override;
  std::vector<Route> routes() override;
  void report(HealthReport& report) const override;
  void write_metrics(MetricsText& out) const override;
  void each_second() override;

  /// "224.5.23.2:10006", and whether packets leave.
  std::string summary() const;
  /// What is missing for packets to leave every way, a line for each; empty when nothing is.
  std::string missing() const;

 private:
  NetworkFacts facts() const;
  std::string broadcast_error() const;

  const Snapshot<Config>& config_;
  MulticastSender& multicast_;
  Snapshot<Geometry> geometry_;
  GeometrySender geometry_sender_;
  std::function<void()> on_new_names_;
  OtherVisions::OnOther on_other_ = [](const VisionMessage&, const std::string&, bool, double) {};
  RefereeListener referee_;
  GroupAddress heard_at_;       // of the thread that applies settings
  HeardPackets heard_packets_;  // before other_visions_, whose thread fills it
  OtherVisions other_visions_;
  PacketTimeline packet_timeline_;
  // As they were seen last: they ask the system for our addresses.
  std::atomic<bool> another_host_sends_ = false;
  Snapshot<CardsUsed> cards_used_{CardsUsed{}};
};

}  // namespace sslv
