// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "recording/match_log_format.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sslv {

/// An event of a match, to find it in a log.
struct MatchEvent {
  enum class Kind { kCommand, kStage, kGoal, kKick };

  std::int64_t time_ns = 0;  // Unix time
  Kind kind = Kind::kCommand;
  std::string text;

  bool operator==(const MatchEvent&) const = default;
};

/// Longer names of teams are shortened, in events and moments.
inline constexpr std::size_t kMaxTeamNameBytes = 60;

/// The game controller's Command in words: "Kick-off, yellow".
std::string command_text(int command);
/// The game controller's Stage in words: "First half".
std::string stage_text(int stage);

const char* name_of(MatchEvent::Kind kind);
/// Throws std::invalid_argument for an unknown name.
MatchEvent::Kind event_kind(std::string_view name);

/// Finds events in the messages of a game controller and a tracker. If several game controllers or trackers
/// send, it follows the first one until that sender has been silent for 5 s.
class MatchEventFinder {
 public:
  /// Further events are dropped, so that no file fills the memory.
  static constexpr std::size_t kMaxEvents = 20'000;

  /// Appends the events of this message to `out`.
  void add(const LoggedMessage& message, std::vector<MatchEvent>& out);
  /// The uuid of the tracker that it follows; empty before one was heard.
  const std::string& tracker() const { return tracker_.source; }

 private:
  struct Followed {
    std::string source;
    std::optional<std::int64_t> heard_ns;
    /// Whether `from` is the followed source. Changes to `from` if the current source has been silent.
    bool follows(const std::string& from, std::int64_t now_ns);
  };
  void add_referee(const LoggedMessage& message, std::vector<MatchEvent>& out);
  void add_tracked(const LoggedMessage& message, std::vector<MatchEvent>& out);

  Followed referee_, tracker_;
  std::optional<int> command_, stage_;
  std::optional<std::array<std::uint32_t, 2>> score_;
  double kick_s_ = 0;  // start of the last kick, in the tracker's time
};

}  // namespace sslv
