// SPDX-License-Identifier: Apache-2.0
#include "net/referee_listener.h"

#include "base/clock.h"
#include "base/plain_text.h"
#include "net/parse.h"
#include "ssl_gc_referee_message.pb.h"

#include <algorithm>
#include <iterator>

#include <glib.h>

namespace sslv {
namespace {

using boost::asio::ip::udp;

bool is_readable(const std::string& text) {
  constexpr std::size_t kLongest = 200;
  return text.size() <= kLongest && g_utf8_validate(text.data(), static_cast<gssize>(text.size()), nullptr);
}

/// A game controller's message names both teams; other messages are refused.
bool is_valid(const Referee& referee) {
  return referee.yellow().has_name() && referee.blue().has_name() && is_readable(referee.yellow().name()) &&
         is_readable(referee.blue().name()) && is_readable(referee.source_identifier());
}

/// Game controllers say "Unknown" for a team that is not chosen yet.
std::string name_of(const Referee::TeamInfo& team) {
  return team.name() == "Unknown" ? "" : plain_part(team.name());
}

// The numbers are the game controller's Stage and Command.
constexpr int kHalt = 0;

bool says_that_stage_is_played(const Referee& referee) {
  constexpr int kPlayingStages[] = {1, 4, 7, 10, 12};  // two halves, two extra halves, penalty shoot-out
  return referee.has_stage() && std::find(std::begin(kPlayingStages), std::end(kPlayingStages),
                                          referee.stage()) != std::end(kPlayingStages);
}

bool says_that_robots_play(const Referee& referee) {
  return says_that_stage_is_played(referee) && referee.has_command() && referee.command() != kHalt;
}

bool says_that_robots_are_handled(const Referee& referee) {
  constexpr int kTimeouts[] = {12, 13};
  return says_that_stage_is_played(referee) && referee.has_command() &&
         (referee.command() == kHalt ||
          std::find(std::begin(kTimeouts), std::end(kTimeouts), referee.command()) != std::end(kTimeouts));
}

std::optional<int> robots_allowed(const Referee::TeamInfo& team) {
  constexpr std::uint32_t kMax = 16;  // number of robot ids
  if (!team.has_max_allowed_bots() || team.max_allowed_bots() > kMax) return std::nullopt;
  return static_cast<int>(team.max_allowed_bots());
}

std::optional<MatchState> match_of(const Referee& referee) {
  if (!referee.has_stage()) return std::nullopt;
  MatchState match{.stage = referee.stage(),
                   .type = referee.match_type(),
                   .is_halted = !referee.has_command() || referee.command() == kHalt,
                   .command = referee.has_command() ? std::optional(referee.command()) : std::nullopt,
                   .time_left_s = {},
                   .score = {referee.yellow().score(), referee.blue().score()}};
  if (referee.has_stage_time_left())
    match.time_left_s = static_cast<double>(referee.stage_time_left()) * 1e-6;
  return match;
}

}  // namespace

bool RefereeStatus::half_is_next() const {
  constexpr int kBeforeHalves[] = {0, 3, 6, 9};
  return match && std::ranges::find(kBeforeHalves, match->stage) != std::end(kBeforeHalves);
}

bool RefereeStatus::is_in_match() const {
  constexpr int kBeforeFirstHalf = 0, kFinished = 13;
  return match && match->stage > kBeforeFirstHalf && match->stage < kFinished &&
         silent_s.value_or(1e9) < kMatchOverAfter_s;
}

RefereeListener::RefereeListener(std::function<void()> on_new_names)
    : on_new_names_(std::move(on_new_names)),
      receiver_("referee", [this](std::span<const std::byte> datagram, const udp::endpoint& sender) {
        receive(datagram, sender, static_cast<double>(steady_ns()) * 1e-9);
      }) {}

void RefereeListener::listen(const std::optional<GroupAddress>& where) {
  if (where_ == where) return;
  receiver_.listen(std::nullopt);
  where_ = where;
  {
    const std::lock_guard lock(mutex_);
    team_names_ = {};
    heard_s_.reset();
    other_heard_s_.reset();
    game_is_running_ = stage_is_played_ = robots_are_handled_ = false;
    robots_allowed_ = {};
    blue_at_positive_x_.reset();
    match_.reset();
  }
  receiver_.listen(where);
}

void RefereeListener::receive(std::span<const std::byte> datagram, const udp::endpoint& sender,
                              double now_s) {
  Referee referee;
  const bool good = parse(referee, datagram) && is_valid(referee);
  {
    const std::lock_guard lock(mutex_);
    if (!good) {
      ++refused_;
      return;
    }
    const std::string address = sender.address().to_string();
    const std::string source = plain_part(referee.source_identifier());
    GameController from{source.empty() ? address : source, address};
    const bool is_other = heard_s_ && from.source != followed_.source;
    if (is_other && now_s - *heard_s_ <= kForgottenAfter_s) {
      other_ = std::move(from);
      other_heard_s_ = now_s;
      return;
    }
    if (is_other) other_heard_s_.reset();  // from now on, that game controller is followed
    followed_ = std::move(from);
    heard_s_ = now_s;
    game_is_running_ = says_that_robots_play(referee);
    stage_is_played_ = says_that_stage_is_played(referee);
    robots_are_handled_ = says_that_robots_are_handled(referee);
    robots_allowed_ = {robots_allowed(referee.yellow()), robots_allowed(referee.blue())};
    blue_at_positive_x_ = referee.has_blue_team_on_positive_half()
                              ? std::optional(referee.blue_team_on_positive_half())
                              : std::nullopt;
    match_ = match_of(referee);
    const std::array<std::string, 2> names{name_of(referee.yellow()), name_of(referee.blue())};
    if (names == team_names_) return;
    team_names_ = names;
  }
  on_new_names_();
}

std::array<std::string, 2> RefereeListener::team_names() const {
  const std::lock_guard lock(mutex_);
  return team_names_;
}

bool RefereeListener::game_is_running() const {
  const std::lock_guard lock(mutex_);
  return game_is_running_;
}

RefereeStatus RefereeListener::status(double now_s) const {
  RefereeStatus status;
  status.error = receiver_.error();
  const std::lock_guard lock(mutex_);
  status.team_names = team_names_;
  if (heard_s_) status.silent_s = std::max(0.0, now_s - *heard_s_);
  if (heard_s_) status.followed = followed_;
  if (other_heard_s_ && now_s - *other_heard_s_ <= kForgottenAfter_s) status.other = other_;
  status.refused = refused_;
  status.game_is_running = game_is_running_;
  status.stage_is_played = stage_is_played_;
  status.robots_are_handled = robots_are_handled_;
  status.robots_allowed = robots_allowed_;
  status.blue_at_positive_x = blue_at_positive_x_;
  status.match = match_;
  return status;
}

}  // namespace sslv
