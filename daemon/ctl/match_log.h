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

/// What a log holds, as JSON and for a terminal.
Json match_log_info_json(const std::filesystem::path& log, const MatchLogIndex& index);
std::string match_log_info_text(const Json& info);

/// What the service says of recordings (docs/openapi.json's Recordings), for a terminal.
std::string recordings_text(const Json& recordings);
/// Likewise of the last seconds and clips (Clips).
std::string clips_text(const Json& clips);

struct PlayOptions {
  double speed = 1;
  double from_s = 0;                // since the log's first message
  std::optional<double> until_s{};  // none: to its end
  double longest_gap_s = 0;         // a longer one is cut to that; 0: none is
  std::string group, interface;
  int vision_port = 10006, referee_port = 10003, tracker_port = 10010;
};

struct Played {
  std::uint64_t vision = 0, referee = 0, tracked = 0, others = 0;
  std::string problem;  // why the log could not be read to its end
};

/// Sends a log's packets again, as far apart as they came, at `speed` times their pace. At a terminal, keys
/// steer it; it says on standard error where it is. Throws StorageError and SettingsError.
Played play_match_log(const std::filesystem::path& log, const PlayOptions& options);

/// What a key does to a log that is played.
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
/// The key that a terminal sent first; takes it from `typed`.
PlayKey take_key(std::string& typed);

/// Keys as a terminal sends them. The bytes of one, an arrow's say, may come one after the other.
class KeyReader {
 public:
  /// Reads from `file`, which stays open. `patience_s`: how long the rest of a key is waited for; without it,
  /// what came is the key Escape, which does nothing.
  explicit KeyReader(int file, double patience_s = 0.1) : file_(file), patience_s_(patience_s) {}

  /// Waits for a key, at most so long. kEnd: the terminal is gone.
  PlayKey next(double seconds);

 private:
  const int file_;
  const double patience_s_;
  std::string typed_;
  double came_s_ = 0;  // the last of it, on the steady clock
};

}  // namespace sslv
