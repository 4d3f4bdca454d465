// SPDX-License-Identifier: Apache-2.0
#include "services/recording/recording_report.h"

#include <utility>

#include <fmt/format.h>

namespace sslv {

void report_recording(const RecordingFacts& facts, HealthReport& report) {
  const auto warn = [&](const char* id, std::string title, std::string fix) {
    report.alerts.push_back({.id = id,
                             .check = "recording",
                             .severity = Severity::kWarn,
                             .title = std::move(title),
                             .fix = std::move(fix),
                             .page = "#/recordings"});
  };
  constexpr const char* kMakeRoom =
      "Delete or download recordings, or let them take more of the disk (Settings, recording).";
  if (!facts.problem.empty()) {
    warn("recording_failed", fmt::format("The match is not recorded: {}", facts.problem),
         "Put that right, then press Record on the page Recordings.");
  } else if (!facts.no_room_problem.empty()) {
    warn("recording_disk", fmt::format("No match can be recorded: {}", facts.no_room_problem), kMakeRoom);
  }
  if (facts.lost > 0) {
    warn("recording_lost",
         fmt::format("The match log lacks {} messages: the disk was too slow, or too much was sent",
                     facts.lost),
         "Use a faster disk, or record on another computer.");
  }
  Check check{"recording", "Match log", CheckState::kPass, kNoFigure, "", ""};
  if (facts.is_recording) {
    check.value = fmt::format("{:.1f}", static_cast<double>(facts.bytes) * 1e-6);
    check.unit = "MB";
    check.text = facts.is_paused ? "paused: there is a break" : "is recorded";
  } else {
    check.text = facts.is_by_hand ? "off: somebody starts it by hand" : "waits for the game controller";
  }
  report.checks.push_back(std::move(check));
}

}  // namespace sslv
