// SPDX-License-Identifier: Apache-2.0
#include "services/recording/match_rule.h"

#include <algorithm>
#include <cstddef>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr std::size_t kMaxPart = 60;

// Numbers of the game controller's Stage and MatchType.
bool is_break(int stage) {
  constexpr int kBreaks[] = {2, 5, 8, 11};
  return std::ranges::find(kBreaks, stage) != std::end(kBreaks);
}
constexpr int kFinished = 13;

const char* match_type(int type) {
  switch (type) {
    case 1: return "GROUP_PHASE";
    case 2: return "ELIMINATION_PHASE";
    case 3: return "FRIENDLY";
    default: return "UNKNOWN_MATCH";
  }
}

}  // namespace

MatchRule::Wish MatchRule::look(const RefereeStatus& referee) {
  const auto& [yellow, blue] = referee.team_names;
  const bool is_over = yellow.empty() || blue.empty() || !referee.match ||
                       referee.match->stage == kFinished ||
                       referee.silent_s.value_or(1e9) > RefereeStatus::kMatchOverAfter_s;
  if (is_over) {
    match_.reset();
    left_out_.reset();
    return Wish::kNone;
  }
  const Match now{referee.team_names, referee.match->type};
  if (match_ != now) {
    // A new match: it begins when robots may move.
    match_.reset();
    if (left_out_ != now) left_out_.reset();
    if (referee.match->is_halted || is_break(referee.match->stage)) return Wish::kNone;
    match_ = named_ = now;
    ++number_;
  }
  if (leaves_match_out()) return Wish::kNone;
  return is_break(referee.match->stage) ? Wish::kPause : Wish::kRecord;
}

std::string MatchRule::name() const {
  return fmt::format("{}_{}-vs-{}", match_type(named_.type), file_name_part(named_.teams[0]),
                     file_name_part(named_.teams[1]));
}

std::string file_name_part(const std::string& text) {
  std::string out;
  bool replaces = false;
  for (const char c : text) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                          ((c == '-' || c == '.') && !out.empty());
    // A letter of several bytes becomes one '_'.
    if (is_plain)
      out += c;
    else if (!replaces)
      out += '_';
    replaces = !is_plain;
    if (out.size() == kMaxPart) break;
  }
  return out;
}

}  // namespace sslv
