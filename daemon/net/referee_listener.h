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

/// The address at which to listen to the game controller. The defaults are the league's.
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
             "IPv4 multicast address that the game controller sends to; its broadcasts are received as well"),
        number("port", &R::port, 1, 65535, "", "UDP port that the game controller sends to"),
        text("interface", &R::interface,
             "name or IPv4 address of the network card on the game controller's network; empty: the "
             "one of network/vision"),
    };
  }
};

struct GameController {
  std::string source;  // the name that it sends, or its address if it sends no name
  std::string address;
};

/// The state of the match by the last message.
struct MatchState {
  int stage = 0;                       // the game controller's Stage
  int type = 0;                        // the game controller's MatchType
  bool is_halted = true;               // the command is HALT or absent
  std::optional<int> command{};        // the game controller's Command; empty if absent
  std::optional<double> time_left_s;   // time left in the stage; negative after the planned end
  std::array<std::uint32_t, 2> score;  // by Team
};

/// The last state received from the game controller.
struct RefereeStatus {
  std::array<std::string, 2> team_names;  // by Team; empty: not received or not chosen yet
  std::optional<double> silent_s;         // time since the last message; empty before the first message
  GameController followed;                // the sender of this state
  std::optional<GameController> other;    // another game controller, received recently but ignored
  std::uint64_t refused = 0;              // invalid datagrams
  std::string error;                      // why nothing can be received; otherwise empty
  bool game_is_running = false;           // robots may play
  bool stage_is_played = false;           // robots may play, or play is interrupted by a HALT
  bool robots_are_handled = false;  // people may remove robots: a HALT or a timeout while a stage is played
  std::array<std::optional<int>, 2> robots_allowed;  // by Team; empty if not sent
  std::optional<bool> blue_at_positive_x;            // the blue team's half; empty if not sent
  std::optional<MatchState> match;                   // empty before a message with a stage

  /// The match counts as over after this time without a message, because the game controller was then
  /// probably switched off. A shorter silence does not end the match.
  static constexpr double kMatchOverAfter_s = 600;
  /// Whether a stage is being played.
  bool match_runs() const { return stage_is_played && silent_s.value_or(1e9) < kMatchOverAfter_s; }
  /// Whether a half or extra half begins next. Not in breaks and after the match, when robots come and go.
  bool half_is_next() const;
  /// Whether the match has begun and is not over: a stage is being played, or there is a break.
  bool is_in_match() const;
};

/// Receives the team names and the state of the game from the game controller. Keeps the last state when the
/// game controller falls silent, because the match continues. If several game controllers send, follows the
/// first one until it has been silent for a few seconds. Thread-safe; receives in its own thread.
class RefereeListener {
 public:
  static constexpr double kForgottenAfter_s = 5;

  /// `on_new_names` is called from the listening thread whenever a team's name changes.
  explicit RefereeListener(std::function<void()> on_new_names);

  /// Listens at `where` from now on, or nowhere, and discards the old state; does nothing if it already
  /// listens there. Must not be called from `on_new_names` or from two threads at the same time.
  void listen(const std::optional<GroupAddress>& where);

  /// Processes one datagram. `now_s`: monotonic receive time. For the listening thread, and for tests that do
  /// not listen.
  void receive(std::span<const std::byte> datagram, const boost::asio::ip::udp::endpoint& sender,
               double now_s);

  std::array<std::string, 2> team_names() const;
  /// True if the last message's stage is a half, an extra half or the shoot-out, and its command is not HALT.
  /// False before the kick-off, in breaks and after the match.
  bool game_is_running() const;
  RefereeStatus status(double now_s) const;
  /// All senders, and the ways in which their packets arrive.
  std::vector<Arrival> arrivals(double now_s) const { return receiver_.arrivals(now_s); }
  std::vector<HeardOn> heard_elsewhere(double now_s) const { return receiver_.heard_elsewhere(now_s); }
  std::string broadcast_error() const { return receiver_.broadcast_error(); }

 private:
  const std::function<void()> on_new_names_;
  std::optional<GroupAddress> where_;
  mutable std::mutex mutex_;  // guards the following members except receiver_
  std::array<std::string, 2> team_names_;
  GameController followed_, other_;
  std::optional<double> heard_s_, other_heard_s_;
  std::uint64_t refused_ = 0;
  bool game_is_running_ = false, stage_is_played_ = false, robots_are_handled_ = false;
  std::array<std::optional<int>, 2> robots_allowed_;
  std::optional<bool> blue_at_positive_x_;
  std::optional<MatchState> match_;
  MulticastReceiver receiver_;  // last: stops before the members it uses are destroyed
};

}  // namespace sslv
