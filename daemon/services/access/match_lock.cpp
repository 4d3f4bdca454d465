// SPDX-License-Identifier: Apache-2.0
#include "services/access/match_lock.h"

#include "base/clock.h"
#include "base/log.h"
#include "web/route.h"

namespace sslv {

MatchLock::State MatchLock::state() {
  // A controller that was switched off must not keep the settings locked.
  constexpr double kMaxSilence_s = 30;
  const RefereeStatus referee = referee_.status(steady_s());
  const bool running = config_.load()->panel.match_lock && referee.game_is_running &&
                       referee.silent_s.value_or(0) < kMaxSilence_s;
  // A HALT, half time or a restarted controller does not end the match.
  if (!config_.load()->panel.match_lock || !referee.is_in_match()) opened_ = false;
  return {running, opened_};
}

MatchLock::State MatchLock::set_opened(bool opened, const std::string& who) {
  const State now = state();
  if (!now.game_is_running && !now.opened) throw HttpError(409, "no match is running: nothing is locked");
  opened_ = opened;
  log::warning("the settings were {} for this match by {}", opened ? "unlocked" : "locked again", who);
  return state();
}

void MatchLock::refuse_if_locked(const std::string& or_what) {
  if (state().is_locked()) throw HttpError(423, kReason + or_what);
}

}  // namespace sslv
