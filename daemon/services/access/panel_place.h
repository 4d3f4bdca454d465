// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/snapshot.h"
#include "config/config.h"
#include "services/access/panel_reach.h"
#include "services/service.h"
#include "settings/passwords.h"
#include "web/server.h"

#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

namespace sslv {

/// Returns the address to listen on; replaces "" with an actual address. Throws SettingsError if other
/// computers can reach the address while no password is set.
std::string listening_address(const PanelSettings& panel, bool has_password);

/// Runs the panel's server at the address in the settings. If that is empty, the panel is reachable only from
/// this computer until a password is set, and then from the network.
class PanelPlace final : public Service {
 public:
  /// The server does not listen before listen(). `reach` receives the addresses at which browsers find the
  /// panel, within a second. All must outlive this.
  PanelPlace(const Snapshot<Config>& config, const Passwords& passwords, Snapshot<PanelReach>& reach)
      : config_(config), passwords_(passwords), reach_(reach) {}

  /// Starts listening at the address in the settings. Call it once. Throws SettingsError.
  void listen(const WebParts& parts, const std::filesystem::path& panel_folder, WebCounters& counters);
  /// Valid after listen().
  int port() const { return server_->port(); }
  /// No request is handled after it returns.
  void stop();

  // Service
  void ask_to_stop() override;
  Plan plan(const SettingsChange& change) const override;
  void each_second() override;

 private:
  Plan plan_move(const PanelSettings& panel) const;
  void follow_settings();
  void look_for_addresses();

  const Snapshot<Config>& config_;
  const Passwords& passwords_;
  std::optional<WebServer> server_;
  Snapshot<PanelReach>& reach_;
  mutable std::mutex mutex_;           // guards place_; held while the panel moves
  std::pair<std::string, int> place_;  // address and port that it listens on, as in the settings
  std::string problem_;                // why the panel could not move; used by each_second()'s thread
};

}  // namespace sslv
