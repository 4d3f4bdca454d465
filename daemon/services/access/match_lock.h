// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/snapshot.h"
#include "config/config.h"
#include "net/referee_listener.h"

#include <atomic>
#include <string>

namespace sslv {

/// Locks the settings while the game controller says that a match is running, unless an admin has unlocked
/// them for this match, including its HALTs and breaks. Thread-safe.
class MatchLock {
 public:
  struct State {
    bool game_is_running = false, opened = false;
    bool is_locked() const { return game_is_running && !opened; }
  };

  /// Both must outlive this.
  MatchLock(const Snapshot<Config>& config, const RefereeListener& referee)
      : config_(config), referee_(referee) {}

  /// Also locks again when the match ends: call it periodically.
  State state();
  /// Valid until the match ends. `who`: the client's address. Throws HttpError 409 if no match is running.
  State set_opened(bool opened, const std::string& who);
  /// Throws HttpError 423 while locked. `or_what`: how the client may override the lock, or "".
  void refuse_if_locked(const std::string& or_what = {});

  static constexpr const char* kReason =
      "the game controller says that the game is running, so the settings are locked: wait for HALT, or "
      "unlock the settings for this match (ssl-visionctl match-lock open)";

 private:
  const Snapshot<Config>& config_;
  const RefereeListener& referee_;
  std::atomic<bool> opened_ = false;
};

}  // namespace sslv
