// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "services/health_report.h"

#include <cstdint>
#include <string>

namespace sslv {

/// How the recording of matches stands.
struct RecordingFacts {
  bool is_recording = false, is_paused = false;
  bool is_by_hand = false;      // nobody but people start it
  std::uint64_t bytes = 0;      // of the log that is recorded
  std::uint64_t lost = 0;       // messages that it lacks
  std::uint64_t refused = 0;    // datagrams that were none of the league's, or more than a field sends
  std::uint64_t cut = 0;        // of strangers, for lack of room
  std::string problem;          // why the last one ended early or could not begin
  std::string no_room_problem;  // why none could begin now
  std::string quota_problem;    // why recordings take more than they may
  std::string left_out;         // why the match that runs is not recorded any more; empty: it may be
};

void report_recording(const RecordingFacts& facts, HealthReport& report);

/// How the cameras' last seconds and clips of them stand.
struct LastSecondsFacts {
  bool is_wanted = false;      // the settings give them memory
  bool is_there = false;       // they have some
  double seconds = 0;          // that all cameras reach back
  std::string problem{};       // why they are shorter than wanted
  std::string clip_problem{};  // why the newest clip was not written
  std::string crash{};         // that the service crashed, and what there is of it
};

void report_last_seconds(const LastSecondsFacts& facts, HealthReport& report);

}  // namespace sslv
