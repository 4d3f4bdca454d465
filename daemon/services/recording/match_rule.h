// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "net/referee_listener.h"

#include <array>
#include <optional>
#include <string>

namespace sslv {

/// What the game controller's words mean for a match log, as the league's own recorder takes them: a match
/// begins when both teams are named and the command is not HALT, pauses in breaks, and ends with the match,
/// when a team has another name, or when the game controller has been silent for long.
class MatchRule {
 public:
  enum class Wish { kNone, kRecord, kPause };

  /// To be called a few times a second.
  Wish look(const RefereeStatus& referee);

  /// An admin ended the log: the match that runs is not recorded again.
  void leave_match_out() { left_out_ = match_; }
  /// The match that runs is one that was left out.
  bool leaves_match_out() const { return match_ && left_out_ == match_; }

  /// Another one for each match that is recorded.
  int number() const { return number_; }
  /// The match that is recorded, or was last: "GROUP_PHASE_Yellow-vs-Blue", as a part of a file's name.
  std::string name() const;

 private:
  struct Match {
    std::array<std::string, 2> teams;
    int type = 0;
    bool operator==(const Match&) const = default;
  };
  std::optional<Match> match_;     // that runs
  std::optional<Match> left_out_;  // until it ends
  Match named_;
  int number_ = 0;
};

/// A text as a part of a file's name: letters and digits of ASCII, '-' and '.' inside; others become '_'.
std::string file_name_part(const std::string& text);

}  // namespace sslv
