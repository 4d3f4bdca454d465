// SPDX-License-Identifier: Apache-2.0
#include "services/network/network_service.h"

#include "base/clock.h"
#include "health/metrics_text.h"
#include "net/network_cards.h"
#include "services/network/packet_report.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <set>
#include <span>
#include <system_error>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

Geometry make_geometry(const Config& config) {
  Geometry geometry{config.field, {}, config.ball_models};
  for (const CameraSettings& camera : config.cameras) {
    if (camera.calibration) {
      geometry.cameras.push_back({static_cast<std::uint32_t>(camera.id), CameraModel(*camera.calibration)});
    }
  }
  return geometry;
}

std::chrono::duration<double> geometry_interval(const Config& config) {
  return std::chrono::duration<double>(config.network.vision.geometry_interval_s);
}

GroupAddress vision_address(const Config& config) {
  const MulticastSettings& vision = config.network.vision;
  return {vision.group, vision.port, vision.interface};
}

std::set<std::string> computers_named(const Config& config) {
  return {config.field.other_computers.begin(), config.field.other_computers.end()};
}

std::optional<GroupAddress> referee_address(const Config& config) {
  const RefereeSettings& referee = config.network.referee;
  if (!referee.enabled) return std::nullopt;
  return GroupAddress{referee.group, referee.port,
                      referee.interface.empty() ? config.network.vision.interface : referee.interface};
}

bool has_address(const NetworkCard& card, const std::string& wanted) {
  return std::ranges::any_of(card.addresses, [&](const auto& one) { return one.to_string() == wanted; });
}

bool is_own(const std::vector<NetworkCard>& cards, const std::string& address) {
  return std::ranges::any_of(cards, [&](const NetworkCard& card) { return has_address(card, address); });
}

/// Programs that send the geometry only have no times.
bool named_host_sends_times(const std::vector<OtherVision>& visions, const std::vector<NetworkCard>& cards) {
  return std::ranges::any_of(visions, [&](const OtherVision& other) {
    return other.is_named && !other.cameras.empty() && !is_own(cards, other.address);
  });
}

std::string with_address(const NetworkCard& card) {
  return fmt::format("{} ({})", card.name, card.addresses.front().to_string());
}

/// Bridges of containers and virtual machines do not lead to teams.
bool is_bridge(const NetworkCard& card) {
  std::error_code ignored;
  return std::filesystem::exists("/sys/class/net/" + card.name + "/bridge", ignored);
}

/// `elsewhere`: computers of the field on other cards, if none is heard on the sending card.
CardsUsed cards_used(const MulticastSettings& vision, const std::vector<NetworkCard>& cards,
                     const std::vector<HeardOn>& elsewhere) {
  const std::string by_route =
      vision.interface.empty() ? address_towards(boost::asio::ip::make_address_v4(vision.group)).to_string()
                               : "";
  const std::string& interface = vision.interface.empty() ? by_route : vision.interface;
  const auto used = std::ranges::find_if(cards, [&](const NetworkCard& card) {
    return !card.addresses.empty() && (card.name == interface || has_address(card, interface));
  });
  if (used == cards.end()) return {};
  CardsUsed out;
  out.sender = with_address(*used);
  std::vector<std::string> others;
  for (const NetworkCard& card : cards) {
    const bool is_usable = card.has_link && card.has_multicast && !card.is_loopback &&
                           !card.addresses.empty() && !is_bridge(card);
    if (is_usable && card.name != used->name) others.push_back(card.name);
  }
  if (used->is_loopback) {
    if (!others.empty()) out.unused = others.front();
    return out;
  }
  if (!used->has_link) out.without_link = used->name;
  if (vision.interface.empty()) out.others = fmt::format("{}", fmt::join(others, " or "));
  if (!elsewhere.empty()) {
    out.heard_on = elsewhere.front().card;
    out.heard = elsewhere.front().address;
  }
  return out;
}

Json interfaces_json() {
  Json interfaces = Json::array();
  for (const NetworkCard& card : network_cards()) {
    Json addresses = Json::array();
    for (const auto& address : card.addresses) addresses.push_back(address.to_string());
    interfaces.push_back({{"name", card.name},
                          {"addresses", addresses},
                          {"is_up", card.is_up},
                          {"has_link", card.has_link},
                          {"is_loopback", card.is_loopback},
                          {"multicast", card.has_multicast}});
  }
  return {{"interfaces", std::move(interfaces)}};
}

}  // namespace

NetworkService::NetworkService(const Snapshot<Config>& config, MulticastSender& multicast)
    : config_(config),
      multicast_(multicast),
      geometry_(make_geometry(*config.load())),
      geometry_sender_(multicast_, geometry_, geometry_interval(*config.load())),
      referee_([this] {
        if (on_new_names_) on_new_names_();
      }),
      other_visions_([this](const auto& sender) { return multicast_.is_own(sender); },
                     [this](std::span<const std::byte> datagram, double now_s) {
                       heard_packets_.receive(datagram, now_s);
                     },
                     [this](const VisionMessage& message, const std::string& address, bool is_named,
                            double now_s) { on_other_(message, address, is_named, now_s); }) {}

void NetworkService::stop_listening() {
  referee_.listen(std::nullopt);
  other_visions_.stop();
}

Plan NetworkService::plan(const SettingsChange& change) const {
  return {.apply = [&self = later(*this),
                    geometry = std::make_shared<const Geometry>(make_geometry(change.next)),
                    vision = change.next.network.vision, interval = geometry_interval(change.next),
                    heard = vision_address(change.next), referee = referee_address(change.next),
                    named = computers_named(change.next)]() mutable noexcept {
    self.multicast_.configure(vision, "/network/vision");
    self.other_visions_.set_named(std::move(named));
    self.geometry_.store(geometry);
    self.geometry_sender_.restart(interval);
    self.other_visions_.listen(heard);
    if (heard != self.heard_at_) self.heard_packets_.clear();  // they are from another group or card
    self.heard_at_ = heard;
    self.referee_.listen(referee);
  }};
}

std::vector<Route> NetworkService::routes() {
  return {{"GET", "/api/network/interfaces", [](const Request&) { return json_response(interfaces_json()); }},
          {"GET", "/api/network/timeline",
           [this](const Request& request) {
             constexpr int kMost = PacketTimeline::kSeconds;
             const int seconds = query_number(request, "seconds", kMost, 1, kMost);
             return json_response(packet_timeline_.to_json(static_cast<std::size_t>(seconds)));
           }},
          {"GET", "/api/network/packets",
           [this](const Request&) {
             return json_response(packets_json({.sent_by = config_.load()->network.vision,
                                                .heard = heard_packets_,
                                                .listening_error = other_visions_.error(),
                                                .vision = other_visions_.arrivals(steady_s()),
                                                .referee = referee_.arrivals(steady_s()),
                                                .broadcast_error = broadcast_error()},
                                               steady_s()));
           }},
          {"GET", "/api/network/listeners",
           [this](const Request&) { return json_response(listeners_json(config_.load()->network.vision)); }}};
}

std::string NetworkService::broadcast_error() const {
  const std::string vision = other_visions_.broadcast_error();
  return vision.empty() ? referee_.broadcast_error() : vision;
}

NetworkFacts NetworkService::facts() const {
  return {.config = config_.load(),
          .multicast = multicast_.status(),
          .geometry = geometry_.load(),
          .other_visions = other_visions_.seen(steady_s()),
          .another_host_sends = another_host_sends_,
          .cards = *cards_used_.load(),
          .listening_error = other_visions_.error(),
          .refused_packets = other_visions_.refused(),
          .referee = referee_.status(steady_s())};
}

void NetworkService::report(HealthReport& report) const {
  const NetworkFacts facts = this->facts();
  report_network(facts, report);
  if (report.status) add_network_status(facts, *report.status);
}

void NetworkService::write_metrics(MetricsText& out) const {
  const MulticastStatus status = multicast_.status();
  out.begin("sslv_packets_sent_total", "counter", "Packets sent to the vision group.");
  out.add({}, status.packets_sent);
  out.begin("sslv_send_errors_total", "counter",
            "Packets that were not sent, or failed by multicast or broadcast.");
  out.add({}, status.send_errors);
}

void NetworkService::each_second() {
  packet_timeline_.add(unix_time_s(), multicast_.status().packets_sent);
  const std::vector<NetworkCard> cards = network_cards();
  another_host_sends_ = named_host_sends_times(other_visions_.seen(steady_s()), cards);
  const auto config = config_.load();
  cards_used_.store(cards_used(config->network.vision, cards, heard_elsewhere(*config, cards)));
}

std::vector<HeardOn> NetworkService::heard_elsewhere(const Config& config,
                                                     const std::vector<NetworkCard>& cards) const {
  const double now_s = steady_s();
  std::vector<HeardOn> out = other_visions_.heard_elsewhere(now_s);
  std::vector<Arrival> here = other_visions_.arrivals(now_s);
  if (config.network.referee.interface.empty()) {  // otherwise the referees have a network of their own
    const auto heard = referee_.heard_elsewhere(now_s);
    out.insert(out.begin(), heard.begin(), heard.end());
    const auto arrived = referee_.arrivals(now_s);
    here.insert(here.end(), arrived.begin(), arrived.end());
  }
  const bool is_any_here =
      std::ranges::any_of(here, [&](const Arrival& one) { return !is_own(cards, one.address); });
  return is_any_here ? std::vector<HeardOn>() : out;
}

std::string NetworkService::summary() const {
  const auto config = config_.load();
  const MulticastSettings& vision = config->network.vision;
  const MulticastStatus status = multicast_.status();
  return fmt::format("{}:{}{}{}", vision.group, vision.port,
                     vision.broadcast.empty() ? "" : fmt::format(" and {}:{}", vision.broadcast, vision.port),
                     status.error.empty() ? ""
                     : status.some_leave  ? " (not both ways)"
                                          : " (not sending)");
}

std::string NetworkService::missing() const {
  const MulticastStatus status = multicast_.status();
  return status.error.empty()
             ? ""
             : fmt::format("{}: {}\n", title_not_sent("packets", status.some_leave), status.error);
}

}  // namespace sslv
