// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/snapshot.h"
#include "config/config.h"
#include "services/access/panel_reach.h"
#include "services/service.h"
#include "settings/passwords.h"
#include "web/server.h"

#include <mutex>
#include <string>
#include <utility>

namespace sslv {

/// Where the panel is to listen: "" has found its meaning. Throws SettingsError when that can be reached from
/// other computers while there is no password.
std::string listening_address(const PanelSettings& panel, bool has_password);

/// Moves the panel to where the settings say, and to the network once there is a password.
class PanelPlace final : public Service {
 public:
  /// `server` listens where listening_address() says for these settings. `reach` says where browsers find it,
  /// at most a second late. All must outlive this.
  PanelPlace(const Snapshot<Config>& config, const Passwords& passwords, WebServer& server,
             Snapshot<PanelReach>& reach);

  Commit prepare(const SettingsChange& change) override;
  void each_second() override;

 private:
  Commit prepare(const PanelSettings& panel);
  void follow_settings();
  void look_for_addresses();

  const Snapshot<Config>& config_;
  const Passwords& passwords_;
  WebServer& server_;
  Snapshot<PanelReach>& reach_;
  std::mutex mutex_;                   // guards the next; held while the panel moves
  std::pair<std::string, int> place_;  // address and port that it listens on, as settings say
  std::string problem_;                // why it could not move; of the thread that calls each_second()
};

}  // namespace sslv
