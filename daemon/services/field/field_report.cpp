// SPDX-License-Identifier: Apache-2.0
#include "services/field/field_report.h"

#include "config/missing_stages.h"
#include "geometry/limits.h"

#include <fmt/format.h>

namespace sslv {
namespace {

/// An image dropped longer ago is not reported.
constexpr double kLately_s = 10;
/// The verdict reports larger differences (verdict_report.cpp).
constexpr double kDisagreeMm = 25;

/// Names the difference before the change; "" if it is unknown. The alert itself has the time of the change.
std::string before_text(const FieldFacts& facts, const CameraPairNow& pair) {
  const auto* history = facts.history ? facts.history->of(pair.camera, pair.other) : nullptr;
  if (!history || !history->since_s || !history->before_mm) return "";
  return fmt::format(" Before, it was {:.1f} mm.", *history->before_mm);
}

void report_drift(const FieldFacts& facts, HealthReport& report) {
  for (const CameraPairNow& pair : pairs_of(facts.agreement)) {
    if (pair.off_mm <= kDriftMm || pair.off_mm > kDisagreeMm) continue;
    if (report.line_alert(pair.camera) || report.line_alert(pair.other)) continue;
    report.alerts.push_back(
        {.id = "camera_drifted",
         .check = "agreement",
         .severity = Severity::kWarn,
         .title = fmt::format("Camera {} differs from camera {} by {:.0f} mm, most at ({:.0f}, {:.0f}) mm",
                              pair.camera, pair.other, pair.off_mm, pair.worst_mm.x(), pair.worst_mm.y()),
         .fix = fmt::format(
             "Was one of them bumped, or is a team's robot height wrong?{} Calibrate it again, or both of "
             "them together.",
             before_text(facts, pair)),
         .page = "#/calibration",
         .camera = pair.camera,
         .about = fmt::format("{} {}", pair.camera, pair.other)});
  }
}

}  // namespace

void report_field(const FieldFacts& facts, HealthReport& report) {
  report_drift(facts, report);
  const RunningStack& running = facts.config->field.running;
  if (const std::string missing = missing_text(running); !missing.empty()) {
    report.alerts.push_back({.id = "stage_missing",
                             .check = "network",
                             .severity = running.idle.empty() ? Severity::kWarn : Severity::kBad,
                             .title = fmt::format("The field's stack runs {}", missing),
                             .fix = missing_fix(running),
                             .page = "#/settings/field/stack"});
  }
  if (!facts.sending_error.empty()) {
    report.alerts.push_back({.id = "tracks_not_sent",
                             .check = "network",
                             .severity = Severity::kWarn,
                             .title = title_not_sent("tracks", facts.some_leave),
                             .fix = facts.sending_error + "; the service tries again automatically.",
                             .page = "#/settings/network/tracker"});
  }
  if (facts.hang) {
    report.alerts.push_back(
        {.id = "field_hangs",
         .check = "network",
         .severity = Severity::kBad,
         .title = fmt::format("The field's thread has hung for {} s{}: there are no tracks",
                              (facts.now_ns - facts.hang->since_ns) / 1'000'000'000, place_text(*facts.hang)),
         .fix = "The stage is faulty: remove it from the field's stack, then restart the service "
                "(systemctl restart ssl-visiond). Detections are still sent.",
         .page = "#/settings/field"});
  }
  report_stages(facts.stack, report);
  std::vector<Alert> twice;
  for (const HeardCameras::Conflict& conflict : facts.conflicts) {
    twice.push_back(
        {.id = "camera_twice",
         .check = "other_visions",
         .severity = Severity::kWarn,
         .title = fmt::format("Two other visions send a camera {}: {} and {}", conflict.camera,
                              conflict.instead_of, conflict.address),
         .fix = fmt::format("Give every camera its own id. Until then, tracks ignore camera {} of {}.",
                            conflict.camera, conflict.address),
         .page = ""});
  }
  report.add_as_one(std::move(twice));
  std::vector<Alert> uncalibrated;
  for (const HeardCameras::Uncalibrated& one : facts.uncalibrated) {
    uncalibrated.push_back(
        {.id = "other_camera_uncalibrated",
         .check = "other_visions",
         .severity = Severity::kWarn,
         .title = fmt::format("Camera {} of {} is not tracked: its calibration is not received", one.camera,
                              one.address),
         .fix =
             "Calibrate the camera on that computer. Its geometry packets must contain the calibration and "
             "the camera's position.",
         .page = ""});
  }
  report.add_as_one(std::move(uncalibrated));
  const LeftOut& left_out = facts.left_out;
  // Negative after the clock was set back: then the age is unknown.
  const double ago_s = facts.now_s - left_out.t_s;
  if (left_out.camera < 0 || !(ago_s >= 0 && ago_s <= kLately_s)) return;
  // Single images are late on a busy computer, or were being processed when the clock was set.
  constexpr std::uint64_t kOffTime = 5;
  if (left_out.why == LeftOut::Why::kTime) {
    if (facts.images_off_time_lately < kOffTime) return;
    report.alerts.push_back(
        {.id = "camera_off_time",
         .check = "agreement",
         .severity = Severity::kWarn,
         .title = fmt::format("Camera {} is left out of the tracks: its image times differ too much from "
                              "this computer's clock",
                              left_out.camera),
         .fix = "Synchronise the clocks of all computers of this field with one time server (NTP or PTP).",
         .page = "",
         .camera = left_out.camera});
  } else if (left_out.why == LeftOut::Why::kTooMany) {
    report.alerts.push_back(
        {.id = "cameras_too_many",
         .check = "agreement",
         .severity = Severity::kWarn,
         .title = fmt::format("Camera {} is left out of the tracks: at most {} cameras are "
                              "tracked",
                              left_out.camera, limits::kMaxCameras),
         .fix = "Remove computers that do not belong to this field from field/other_computers.",
         .page = "#/settings/field"});
  }
}

}  // namespace sslv
