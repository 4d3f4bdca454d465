// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "config/config.h"

#include <cstddef>
#include <filesystem>
#include <iosfwd>
#include <string>

namespace sslv {

/// How steady robots and balls are, as cameras saw them or as they are tracked.
struct Steadiness {
  std::size_t seen = 0;   // places told
  std::size_t gaps = 0;   // times that one was gone for longer than kGap_s, and came back within kBack_s
  double gaps_s = 0;      // so long altogether
  std::size_t jumps = 0;  // from one to the next farther than anything moves in that time
  double worst_jump_mm = 0;

  static constexpr double kGap_s = 0.1, kBack_s = 2;
};

struct TrackedLog {
  double seconds = 0;
  std::size_t packets = 0, cameras = 0;
  Steadiness robots_before, robots_after;  // sightings of all cameras in the order of their times; tracks
  Steadiness ball_before, ball_after;      // the surest ball of an image; the one that is played
  std::size_t kicks = 0;
};

struct TrackLogOptions {
  double later_s = 0;              // tracks as they are known so much later; 0: as they are at once
  std::ostream* tracks = nullptr;  // gets a line of JSON, as docs/openapi.json's FieldTracks, for each packet
};

/// Runs the field's stack over the vision packets of a log of the league's logger. Throws StorageError.
TrackedLog track_log(const std::filesystem::path& file, const Config& config, const TrackLogOptions& options);

Json tracked_log_json(const TrackedLog& log);
std::string tracked_log_text(const TrackedLog& log);

}  // namespace sslv
