// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "config/config.h"

#include <cstddef>
#include <filesystem>
#include <iosfwd>
#include <string>

namespace sslv {

/// Steadiness of positions, as measured by cameras or as tracked.
struct Steadiness {
  std::size_t seen = 0;   // number of positions
  std::size_t gaps = 0;   // absences longer than kGap_s that ended within kBack_s
  double gaps_s = 0;      // total duration of the gaps
  std::size_t jumps = 0;  // steps from one position to the next that are larger than any motion in that time
  double worst_jump_mm = 0;

  static constexpr double kGap_s = 0.1, kBack_s = 2;
};

struct TrackedLog {
  double seconds = 0;
  std::size_t packets = 0, cameras = 0;
  Steadiness robots_before, robots_after;  // before: measurements of all cameras, by time; after: tracks
  Steadiness ball_before, ball_after;      // before: most confident ball of an image; after: ball in play
  std::size_t kicks = 0;
};

struct TrackLogOptions {
  double later_s = 0;              // smoothed tracks with this delay; 0: tracks without delay
  std::ostream* tracks = nullptr;  // gets a JSON line for each packet: FieldTracks of docs/openapi.json
};

/// Runs the field's stack over the vision packets of a log of the league's logger. Throws StorageError.
TrackedLog track_log(const std::filesystem::path& file, const Config& config, const TrackLogOptions& options);

Json tracked_log_json(const TrackedLog& log);
std::string tracked_log_text(const TrackedLog& log);

}  // namespace sslv
