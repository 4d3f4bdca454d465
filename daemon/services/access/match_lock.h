// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/snapshot.h"
#include "config/config.h"
#include "net/referee_listener.h"

#include <atomic>
#include <string>

namespace sslv {

/// While a match runs, as the game controller says, nothing is changed unless an admin has unlocked it for
/// this match, with its HALTs and breaks. May be used from any thread.
class MatchLock {
 public:
  struct State {
    bool game_is_running = false, opened = false;
    bool is_locked() const { return game_is_running && !opened; }
  };

  /// Both must outlive this.
  MatchLock(const Snapshot<Config>& config, const RefereeListener& referee)
      : config_(config), referee_(referee) {}

  /// It is closed again when the match ends: to be asked now and then.
  State state();
  /// Until the match ends. `who`: the client's address. Throws HttpError 409 when no match runs.
  State set_opened(bool opened, const std::string& who);
  /// Throws HttpError 423 while it is locked. `or_what`: how the client may insist, or "".
  void refuse_if_locked(const std::string& or_what = {});

  static constexpr const char* kReason =
      "the game controller says that the game is running, so the settings are locked: wait for HALT, or "
      "unlock the settings for this match";

 private:
  const Snapshot<Config>& config_;
  const RefereeListener& referee_;
  std::atomic<bool> opened_ = false;
};

}  // namespace sslv
