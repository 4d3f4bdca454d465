// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"
#include "geometry/scene.h"
#include "net/multicast_receiver.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sslv {

/// Where the game controller is heard. The defaults are the league's.
struct RefereeSettings {
  bool enabled = true;
  std::string group = "224.5.23.1";
  int port = 10003;
  std::string interface;

  static constexpr auto fields() {
    using R = RefereeSettings;
    return std::tuple{
        flag("enabled", &R::enabled, "listen to the game controller"),
        text("group", &R::group,
             "IPv4 multicast address that the game controller sends to; its broadcasts are heard as well"),
        number("port", &R::port, 1, 65535, "", "UDP port that the game controller sends to"),
        text("interface", &R::interface,
             "name or IPv4 address of the network card on the game controller's network; empty: the "
             "one of network/vision"),
    };
  }
};

struct GameController {
  std::string source;  // as it names itself; its address when it does not
  std::string address;
};

/// How the match stands, as the last message says.
struct MatchState {
  int stage = 0;                       // the game controller's Stage
  int type = 0;                        // its MatchType
  bool is_halted = true;               // its command is HALT, or it says none
  std::optional<int> command{};        // the game controller's Command; none: it says none
  std::optional<double> time_left_s;   // of the stage; negative when it lasts longer than it should
  std::array<std::uint32_t, 2> score;  // by Team
};

/// What the game controller has said.
struct RefereeStatus {
  std::array<std::string, 2> team_names;  // by Team; empty: not said yet
  std::optional<double> silent_s;         // since its last message; none: there was none
  GameController followed;                // who sent it
  std::optional<GameController> other;    // heard lately too, and not followed
  std::uint64_t refused = 0;              // datagrams that could not be read
  std::string error;                      // why nothing can be heard; empty when it can
  bool game_is_running = false;           // robots may play
  bool stage_is_played = false;           // the same, or a HALT in between
  bool robots_are_handled = false;        // meanwhile: people may take them off, in a HALT or a timeout
  std::array<std::optional<int>, 2> robots_allowed;  // by Team; none: it does not say
  std::optional<bool> blue_at_positive_x;            // that half is the blue team's; none: it does not say
  std::optional<MatchState> match;                   // none before a message with a stage

  /// A game controller that falls silent for a while does not end a match; one that was switched off long ago
  /// does.
  static constexpr double kMatchOverAfter_s = 600;
  /// A stage is played.
  bool match_runs() const { return stage_is_played && silent_s.value_or(1e9) < kMatchOverAfter_s; }
  /// It has begun and is not over: a stage is played, or there is a break.
  bool is_in_match() const;
};

/// Hears from the game controller how the teams are named and whether the game runs. Both stay as they are
/// when it falls silent: the match goes on. Of several, the first is followed until it is silent for some
/// seconds. May be used from any thread; listens in one of its own.
class RefereeListener {
 public:
  static constexpr double kForgottenAfter_s = 5;

  /// `on_new_names` is called, from the listening thread, whenever a team has another name.
  explicit RefereeListener(std::function<void()> on_new_names);

  /// Listens there from now on, or nowhere, and forgets what was heard elsewhere; nothing happens when it
  /// listens there already. Not for `on_new_names`, nor for two threads at once.
  void listen(const std::optional<GroupAddress>& where);

  /// Takes one datagram, at a monotonic time. For the listening thread, and for tests that do not listen.
  void receive(std::span<const std::byte> datagram, const boost::asio::ip::udp::endpoint& sender,
               double now_s);

  std::array<std::string, 2> team_names() const;
  /// The last message's stage is a half, an extra half or the shoot-out, and its command any but HALT. Before
  /// the kick-off, in breaks and after the match it is not running.
  bool game_is_running() const;
  RefereeStatus status(double now_s) const;
  /// Who sends there, and which way it comes.
  std::vector<Arrival> arrivals(double now_s) const { return receiver_.arrivals(now_s); }
  std::string broadcast_error() const { return receiver_.broadcast_error(); }

 private:
  const std::function<void()> on_new_names_;
  std::optional<GroupAddress> where_;
  mutable std::mutex mutex_;  // guards those below but for the last
  std::array<std::string, 2> team_names_;
  GameController followed_, other_;
  std::optional<double> heard_s_, other_heard_s_;
  std::uint64_t refused_ = 0;
  bool game_is_running_ = false, stage_is_played_ = false, robots_are_handled_ = false;
  std::array<std::optional<int>, 2> robots_allowed_;
  std::optional<bool> blue_at_positive_x_;
  std::optional<MatchState> match_;
  MulticastReceiver receiver_;  // last, so that it ends before what it uses
};

}  // namespace sslv
