// SPDX-License-Identifier: Apache-2.0
#include "services/access/panel_place.h"

#include "base/error.h"
#include "base/log.h"

#include <exception>
#include <functional>
#include <memory>

#include <boost/asio/ip/address.hpp>
#include <fmt/format.h>

namespace sslv {
namespace {

std::pair<std::string, int> place_of(const PanelSettings& panel, const Passwords& passwords) {
  return {listening_address(panel, passwords.has(Role::kAdmin)), panel.port};
}

}  // namespace

std::string listening_address(const PanelSettings& panel, bool has_password) {
  if (panel.address.empty()) return has_password ? "0.0.0.0" : "127.0.0.1";
  boost::system::error_code error;
  const auto address = boost::asio::ip::make_address(panel.address, error);
  if (!has_password && (error || !address.is_loopback())) {
    throw SettingsError(
        fmt::format("/panel/address: \"{}\" can be reached from other computers and no password is set; set "
                    "one first (sudo ssl-visionctl passwd), or use 127.0.0.1",
                    panel.address));
  }
  return panel.address;
}

void PanelPlace::listen(const WebParts& parts, const std::filesystem::path& panel_folder,
                        WebCounters& counters) {
  {
    const std::lock_guard lock(mutex_);  // requests may arrive before emplace() returns
    place_ = place_of(config_.load()->panel, passwords_);
    server_.emplace(parts, WebOptions{place_.first, place_.second, panel_folder}, counters);
  }
  look_for_addresses();
}

void PanelPlace::stop() {
  if (server_) server_->stop();
}

void PanelPlace::ask_to_stop() {
  if (server_) server_->ask_to_stop();
}

Plan PanelPlace::plan(const SettingsChange& change) const {
  return plan_move(change.next.panel);
}

Plan PanelPlace::plan_move(const PanelSettings& panel) const {
  const auto place = place_of(panel, passwords_);
  const std::lock_guard lock(mutex_);
  if (!server_ || place == place_) return {};
  // If the setting is unchanged, keep the actual port: for port 0, the system has chosen it.
  const int port = place.second == place_.second ? server_->port() : place.second;
  const auto move = std::make_shared<std::function<void()>>();
  auto& self = later(*this);
  return {.get_ready =
              [&self, place, port, move] {
                const std::lock_guard moving(self.mutex_);
                *move = self.server_->move_to(place.first, port);
              },
          .apply =
              [&self, place, move]() noexcept {
                const std::lock_guard moving(self.mutex_);
                (*move)();
                self.place_ = place;
                log::info("panel on {} port {}", place.first, self.server_->port());
              }};
}

void PanelPlace::each_second() {
  follow_settings();
  look_for_addresses();
}

void PanelPlace::follow_settings() {
  const auto config = config_.load();
  if (!config->panel.address.empty()) return;
  try {
    const Plan plan = plan_move(config->panel);
    plan.get_ready();
    plan.apply();
    problem_.clear();
  } catch (const std::exception& error) {
    if (problem_ != error.what()) log::error("the panel keeps its address: {}", error.what());
    problem_ = error.what();
  }
}

/// Called once a second, because network cards and their addresses change.
void PanelPlace::look_for_addresses() {
  std::string listens_on;
  {
    const std::lock_guard lock(mutex_);
    listens_on = place_.first;
  }
  PanelReach reach = panel_reach(listens_on, server_->port(), network_cards());
  if (*reach_.load() != reach) reach_.store(std::move(reach));
}

}  // namespace sslv
