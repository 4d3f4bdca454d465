// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "services/health_report.h"

#include <cstdint>
#include <string>

namespace sslv {

/// State of match recording.
struct RecordingFacts {
  bool is_recording = false, is_paused = false;
  bool is_by_hand = false;      // logs are only started by hand
  std::uint64_t bytes = 0;      // size of the current log
  std::uint64_t lost = 0;       // messages missing from the log
  std::uint64_t refused = 0;    // datagrams that were not the league's messages, or above the rate limit
  std::uint64_t cut = 0;        // strangers' messages dropped for lack of space
  std::string problem;          // why the last log ended early or could not begin
  std::string no_room_problem;  // why no log could begin now
  std::string quota_problem;    // why recordings exceed the quota
  std::string left_out;         // why the current match is excluded; empty: it is not
};

void report_recording(const RecordingFacts& facts, HealthReport& report);

/// State of the cameras' last seconds, which are kept in memory, and of the clips.
struct LastSecondsFacts {
  bool is_wanted = false;      // the settings reserve memory for the last seconds
  bool is_there = false;       // the memory is allocated
  double seconds = 0;          // minimum over the cameras
  std::string problem{};       // why the last seconds are shorter than wanted
  std::string clip_problem{};  // why the newest clip was not written
  std::string crash{};         // message about a crash and its clip; empty: no crash
};

void report_last_seconds(const LastSecondsFacts& facts, HealthReport& report);

}  // namespace sslv
