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

/// What happened in a match, for those who look for it in a log.
struct MatchEvent {
  enum class Kind { kCommand, kStage, kGoal, kKick };

  std::int64_t time_ns = 0;  // Unix time
  Kind kind = Kind::kCommand;
  std::string text;

  bool operator==(const MatchEvent&) const = default;
};

/// "Kick-off, yellow": the game controller's Command, for people.
std::string command_text(int command);
/// "First half": its Stage.
std::string stage_text(int stage);

const char* name_of(MatchEvent::Kind kind);
/// Throws std::invalid_argument.
MatchEvent::Kind event_kind(std::string_view name);

/// Finds events in what the game controller and a tracker say. Of several of each, the first is followed
/// until it has been silent for five seconds.
class MatchEventFinder {
 public:
  /// More are not kept, so that no file fills the memory.
  static constexpr std::size_t kMaxEvents = 20'000;

  /// Adds to `out` what this message tells.
  void add(const LoggedMessage& message, std::vector<MatchEvent>& out);

 private:
  struct Followed {
    std::string source;
    std::optional<std::int64_t> heard_ns;
    /// Whether what this source says counts.
    bool follows(const std::string& from, std::int64_t now_ns);
  };
  void add_referee(const LoggedMessage& message, std::vector<MatchEvent>& out);
  void add_tracked(const LoggedMessage& message, std::vector<MatchEvent>& out);

  Followed referee_, tracker_;
  std::optional<int> command_, stage_;
  std::optional<std::array<std::uint32_t, 2>> score_;
  double kick_s_ = 0;  // when the last kick began
};

}  // namespace sslv
