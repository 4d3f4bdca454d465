// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "services/access/access.h"
#include "services/access/match_lock.h"
#include "services/access/panel_reach.h"
#include "services/service.h"
#include "settings/passwords.h"

#include <string>
#include <string_view>
#include <vector>

namespace sslv {

/// Access control: passwords, sessions, the match lock.
class AccessService final : public Service, public Gate {
 public:
  /// All must outlive this. The cookie's name contains the panel's port because browsers share cookies
  /// between the ports of a computer. `reach`: see PanelPlace.
  AccessService(const Snapshot<Config>& config, Passwords& passwords, MatchLock& match_lock,
                const Snapshot<PanelReach>& reach);

  // Gate
  void refresh() override { passwords_.reload_if_changed(); }  // ssl-visionctl may have changed them
  May may(std::string_view cookies) override { return access_.may(cookies); }
  std::string lock_reason() override { return match_lock_.state().is_locked() ? MatchLock::kReason : ""; }
  std::vector<std::string> names() const override { return config_.load()->panel.names; }
  bool is_trusted(const std::string& address) override { return access_.is_trusted(address); }

  // Service
  std::vector<Route> routes() override;
  void report(HealthReport& report) const override;
  void each_second() override;
  std::vector<Event> take_events() override { return events_.take(); }

 private:
  Response state_response(const std::string& cookies);
  Response set_cookie_response(const std::string& set_cookie);
  Response sign_in(const Request& request);
  Response sign_out(const Request& request);
  Response set_password(const Request& request);
  Response set_lock(const Request& request);

  const Snapshot<Config>& config_;
  Passwords& passwords_;
  MatchLock& match_lock_;
  const Snapshot<PanelReach>& reach_;
  Access access_;
  EventQueue events_;
  bool was_running_ = false;  // whether the game was running at the last each_second()
};

}  // namespace sslv
