// SPDX-License-Identifier: Apache-2.0
#include "services/recording/recording_report.h"

#include <utility>

#include <fmt/format.h>

namespace sslv {

namespace {

/// Always a warning: problems with recordings do not stop a match.
void warn_of(const char* check, const char* id, std::string title, std::string fix, HealthReport& report) {
  report.alerts.push_back({.id = id,
                           .check = check,
                           .severity = Severity::kWarn,
                           .title = std::move(title),
                           .fix = std::move(fix),
                           .page = "#/recordings"});
}

}  // namespace

void report_recording(const RecordingFacts& facts, HealthReport& report) {
  const auto warn = [&](const char* id, std::string title, std::string fix) {
    warn_of("recording", id, std::move(title), std::move(fix), report);
  };
  constexpr const char* kMakeRoom =
      "Download and delete recordings, or give them more disk space (Settings, recording).";
  if (!facts.problem.empty()) {
    warn("recording_failed", fmt::format("The match is not recorded: {}", facts.problem),
         "Fix the cause, then press Record on the Recordings page.");
  } else if (!facts.no_room_problem.empty()) {
    warn("recording_disk", fmt::format("No match can be recorded: {}", facts.no_room_problem), kMakeRoom);
  } else if (!facts.quota_problem.empty()) {
    warn("recording_disk", fmt::format("Too much is kept: {}", facts.quota_problem), kMakeRoom);
  }
  if (!facts.left_out.empty() && facts.problem.empty() && !facts.is_recording && !facts.is_by_hand) {
    warn("recording_stopped", fmt::format("This match is not recorded: {}", facts.left_out),
         "Press Record on the Recordings page to record the rest of it. The next match is recorded again.");
  }
  if (facts.lost > 0) {
    warn("recording_lost",
         fmt::format("The match log lacks {} messages: the disk was too slow, or too much was sent",
                     facts.lost),
         "Use a faster disk, or record on another computer.");
  }
  constexpr std::uint64_t kStrays = 100;  // a few are harmless
  if (facts.refused > kStrays) {
    warn("recording_refused",
         fmt::format("The match log drops {} datagrams sent to the field's groups: they are not the league's "
                     "messages, or are more than a field sends",
                     facts.refused),
         "Find the program that sends them, and remove it from the field's network.");
  }
  if (facts.cut > kStrays) {
    warn("recording_cut",
         fmt::format(
             "The match log drops {} messages from computers that are not in the settings: recordings have "
             "little space left",
             facts.cut),
         "Delete recordings, or give them more disk space (Settings, recording), or list the computers "
         "(Settings, field, other_computers).");
  }
  Check check{"recording", "Match log", CheckState::kPass, kNoFigure, "", ""};
  if (facts.is_recording) {
    check.value = fmt::format("{:.1f}", static_cast<double>(facts.bytes) * 1e-6);
    check.unit = "MB";
    check.text = facts.is_paused ? "paused: there is a break" : "recording";
  } else {
    check.text = facts.is_by_hand ? "off: somebody starts it by hand" : "waits for the game controller";
  }
  report.checks.push_back(std::move(check));
}

void report_last_seconds(const LastSecondsFacts& facts, HealthReport& report) {
  constexpr const char* kCheck = "last_seconds";
  if (!facts.crash.empty()) {
    warn_of(kCheck, "service_crashed", facts.crash,
            "Report it, with the support bundle (Diagnostics page) and the clip, if there is one.", report);
  }
  if (!facts.clip_problem.empty()) {
    warn_of(kCheck, "clip_failed", fmt::format("A clip was not written: {}", facts.clip_problem),
            "Fix the cause, then keep the last seconds again on the Recordings page.", report);
  }
  if (!facts.problem.empty()) {
    warn_of(
        kCheck, "clip_memory", fmt::format("The last seconds are shorter than wanted: {}", facts.problem),
        "Close other programs, add memory, raise the service's limit, or ask for less (Settings, recording).",
        report);
  }
  Check check{kCheck, "Last seconds", CheckState::kPass, kNoFigure, "", ""};
  if (!facts.is_wanted) {
    check.text = "off: no images are kept in memory";
  } else if (!facts.is_there) {
    check.state = CheckState::kUnknown;
    check.text = "no images are in memory yet";
  } else {
    check.value = fmt::format("{:.1f}", facts.seconds);
    check.unit = "s";
    check.text = "of images are in memory";
  }
  report.checks.push_back(std::move(check));
}

}  // namespace sslv
