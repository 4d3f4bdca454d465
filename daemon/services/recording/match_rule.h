// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "net/referee_listener.h"

#include <array>
#include <optional>
#include <string>

namespace sslv {

/// Decides from the game controller's state when to record a match, like the league's own recorder: a
/// recording begins when both teams are named and the command is not HALT, pauses in breaks, and ends with
/// the match, when other teams play, or when the game controller has been silent for
/// RefereeStatus::kMatchOverAfter_s. Teams that switch colours continue their match.
class MatchRule {
 public:
  enum class Wish { kNone, kRecord, kPause };

  /// Call it a few times a second.
  Wish look(const RefereeStatus& referee);

  /// Excludes the current match from recording.
  void leave_match_out() { left_out_ = match_; }
  /// Whether the current match is excluded from recording.
  bool leaves_match_out() const { return match_ && left_out_ == match_; }

  /// Changes with each match that is recorded.
  int number() const { return number_; }
  /// The current or last recorded match, as part of a file name: "GROUP_PHASE_Yellow-vs-Blue".
  std::string name() const;

 private:
  struct Match {
    std::array<std::string, 2> teams;
    int type = 0;
    bool operator==(const Match& other) const {
      return type == other.type &&
             (teams == other.teams || (teams[0] == other.teams[1] && teams[1] == other.teams[0]));
    }
  };
  std::optional<Match> match_;     // the current match
  std::optional<Match> left_out_;  // the excluded match, until it ends
  Match named_;
  int number_ = 0;
};

/// Converts a text to at most 60 bytes of a file name. Keeps ASCII letters, digits, and '-' and '.' except at
/// the beginning; replaces each sequence of other characters with one '_'.
std::string file_name_part(const std::string& text);

}  // namespace sslv
