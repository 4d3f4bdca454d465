// SPDX-License-Identifier: Apache-2.0
// Who may do what and when: passwords, files that settings may name, the match lock, where the panel listens.
#include "base/clock.h"
#include "base/log.h"
#include "daemon.h"
#include "settings/named_files.h"

namespace sslv {

void Daemon::check_files(const Json& settings) const {
  static const Json kSchema = settings_schema();
  check_named_files(kSchema, settings, {*settings_.load()}, file_folders_);
}

MatchLock Daemon::match_lock() const {
  // A controller that was switched off locks nobody out.
  constexpr double kLongestSilence_s = 30;
  const RefereeStatus referee = referee_.status(steady_s());
  const bool running = config_.load()->panel.match_lock && referee.game_is_running &&
                       referee.silent_s.value_or(0) < kLongestSilence_s;
  if (!running) match_lock_opened_ = false;
  return {running, match_lock_opened_};
}

void Daemon::add_access_to(WebHost& host) {
  host.access = &access_;
  host.panel_names = [this] { return config_.load()->panel.names; };
  host.match_lock = [this] { return match_lock(); };
  host.open_match_lock = [this](bool opened, const std::string& who) {
    if (!match_lock().game_is_running) throw HttpError(409, "no match is running: nothing is locked");
    match_lock_opened_ = opened;
    log::warning("the settings were {} for this match by {}", opened ? "unlocked" : "locked again", who);
    return match_lock();
  };
}

std::function<void()> Daemon::prepare_panel(const PanelSettings& panel) {
  const std::pair place{listening_address(panel, passwords_.has(Role::kAdmin)), panel.port};
  const std::lock_guard lock(panel_mutex_);
  if (!panel_may_move_ || place == panel_place_) return [] {};
  const int port = place.second == panel_place_.second ? web_->port() : place.second;  // 0 stays what was found
  return [this, place, move = web_->move_to(place.first, port)] {
    const std::lock_guard moving(panel_mutex_);
    move();
    panel_place_ = place;
    log::info("panel on {} port {}", place.first, web_->port());
  };
}

void Daemon::move_panel_if_needed() {
  passwords_.look_again();
  match_lock();  // it is closed again when the match ends, also while nobody asks
  const auto config = config_.load();
  if (!config->panel.address.empty()) return;
  try {
    prepare_panel(config->panel)();
    panel_problem_.clear();
  } catch (const std::exception& error) {
    if (panel_problem_ != error.what()) log::error("the panel stays where it is: {}", error.what());
    panel_problem_ = error.what();
  }
}

}  // namespace sslv
