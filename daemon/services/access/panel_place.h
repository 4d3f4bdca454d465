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

/// Where the panel is to listen: "" has found its meaning. Throws SettingsError when that can be reached from
/// other computers while there is no password.
std::string listening_address(const PanelSettings& panel, bool has_password);

/// The panel's server: where the settings say, and on the network once there is a password.
class PanelPlace final : public Service {
 public:
  /// Nobody listens before listen(). `reach` says where browsers find it, at most a second late. All must
  /// outlive this.
  PanelPlace(const Snapshot<Config>& config, const Passwords& passwords, Snapshot<PanelReach>& reach)
      : config_(config), passwords_(passwords), reach_(reach) {}

  /// Once, where the settings say. Throws SettingsError.
  void listen(const WebParts& parts, const std::filesystem::path& panel_folder, WebCounters& counters);
  /// Once it listens.
  int port() const { return server_->port(); }
  /// From here on nobody asks for anything.
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
  mutable std::mutex mutex_;           // guards the next; held while the panel moves
  std::pair<std::string, int> place_;  // address and port that it listens on, as settings say
  std::string problem_;                // why it could not move; of the thread that calls each_second()
};

}  // namespace sslv
