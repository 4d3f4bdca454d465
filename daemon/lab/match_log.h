// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "recording/match_log_index.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

namespace sslv {

/// The content of a log, as JSON and for a terminal.
Json match_log_info_json(const std::filesystem::path& log, const MatchLogIndex& index);
std::string match_log_info_text(const Json& info);

struct PlayOptions {
  double speed = 1;
  double from_s = 0;                // since the log's first message
  std::optional<double> until_s{};  // none: until its end
  double longest_gap_s = 0;         // longer gaps are cut to this; 0: none is cut
  std::string group, interface;
  int vision_port = 10006, referee_port = 10003, tracker_port = 10010;
};

struct Played {
  std::uint64_t vision = 0, referee = 0, tracked = 0, others = 0;
  std::string problem;  // why the log could not be read to its end; empty if it could
};

/// Sends a log's packets again with their original intervals, at `speed` times their pace. At a terminal,
/// keys control it, and standard error shows the position. Throws StorageError and SettingsError.
Played play_match_log(const std::filesystem::path& log, const PlayOptions& options);

/// Effect of a key while a log is played.
enum class PlayKey {
  kNone,
  kPause,
  kStep,
  kBack,
  kOn,
  kFaster,
  kSlower,
  kNextGoal,
  kLastGoal,
  kNextCommand,
  kLastCommand,
  kNextKick,
  kLastKick,
  kEnd
};
/// Returns the first key that a terminal sent and removes it from `typed`.
PlayKey take_key(std::string& typed);

/// Reads keys from a terminal. The bytes of a key, such as an arrow, may arrive one after the other.
class KeyReader {
 public:
  /// Reads from `file`, which stays open. `patience_s`: how long to wait for the rest of a key; after that,
  /// its bytes count as the key Escape, which does nothing.
  explicit KeyReader(int file, double patience_s = 0.1) : file_(file), patience_s_(patience_s) {}

  /// Waits for a key for at most `seconds`. kEnd: the terminal is gone.
  PlayKey next(double seconds);

 private:
  const int file_;
  const double patience_s_;
  std::string typed_;
  double came_s_ = 0;  // arrival time of the last byte of typed_ (steady clock)
};

}  // namespace sslv
