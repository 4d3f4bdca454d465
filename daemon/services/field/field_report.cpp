// SPDX-License-Identifier: Apache-2.0
#include "services/field/field_report.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

/// What was left out so long ago is over.
constexpr double kLately_s = 10;
/// Calibrations are good to a millimetre or two; farther apart, one of the cameras is no longer where it was.
/// The verdict says what is too far to play (verdict_report.cpp).
constexpr double kDriftMm = 5, kDisagreeMm = 25;
constexpr float kMinSamples = 30;  // in a part of the field
constexpr std::size_t kMinParts = 3;

void report_drift(const AgreementNow& agreement, HealthReport& report) {
  for (const CameraPairNow& pair : pairs_of(agreement)) {
    if (pair.off_mm <= kDriftMm || pair.off_mm > kDisagreeMm) continue;
    report.alerts.push_back(
        {.id = "camera_drifted",
         .check = "agreement",
         .severity = Severity::kWarn,
         .title = fmt::format("Camera {} differs from camera {} by {:.0f} mm, most at ({:.0f}, {:.0f}) mm",
                              pair.camera, pair.other, pair.off_mm, pair.worst_mm.x(), pair.worst_mm.y()),
         .fix = "Was one of them bumped? Calibrate it again, or both of them together.",
         .page = "#/calibration",
         .camera = pair.camera,
         .about = fmt::format("{} {}", pair.camera, pair.other)});
  }
}

}  // namespace

std::vector<CameraPairNow> pairs_of(const AgreementNow& agreement) {
  std::map<std::pair<int, int>, std::vector<const AgreementNow::Difference*>> parts;
  for (std::size_t i = 0; i < agreement.difference_count; ++i) {
    const AgreementNow::Difference& one = agreement.differences[i];
    if (one.samples >= kMinSamples) parts[{one.camera, one.other}].push_back(&one);
  }
  const auto length = [](const AgreementNow::Difference* one) {
    return static_cast<double>(std::hypot(one->off_x_mm, one->off_y_mm));
  };
  std::vector<CameraPairNow> out;
  std::map<int, double> worst_of;  // by camera
  for (auto& [cameras, places] : parts) {
    if (places.size() < kMinParts) continue;
    std::sort(places.begin(), places.end(),
              [&](const auto* a, const auto* b) { return length(a) < length(b); });
    const auto* worst = places.back();
    out.push_back({.camera = cameras.first,
                   .other = cameras.second,
                   .off_mm = length(places[places.size() / 2]),
                   .parts = places.size(),
                   .worst_mm = {worst->x_mm, worst->y_mm}});
    worst_of[cameras.first] += out.back().off_mm;
    worst_of[cameras.second] += out.back().off_mm;
  }
  // First the one that others differ from, too.
  for (CameraPairNow& pair : out) {
    if (worst_of[pair.other] > worst_of[pair.camera]) std::swap(pair.camera, pair.other);
  }
  return out;
}

void report_field(const FieldFacts& facts, HealthReport& report) {
  report_drift(facts.agreement, report);
  if (!facts.sending_error.empty()) {
    report.alerts.push_back({.id = "tracks_not_sent",
                             .check = "network",
                             .severity = Severity::kWarn,
                             .title = "No tracks are sent",
                             .fix = facts.sending_error + "; the service tries again automatically.",
                             .page = "#/settings/network/tracker"});
  }
  for (const HeardCameras::Conflict& conflict : facts.conflicts) {
    if (conflict.instead_of.empty()) continue;  // the network service says so of our own cameras
    report.alerts.push_back(
        {.id = "camera_twice",
         .check = "other_visions",
         .severity = Severity::kWarn,
         .title = fmt::format("Two other visions send a camera {}: {} and {}", conflict.camera,
                              conflict.instead_of, conflict.address),
         .fix =
             fmt::format("Give every camera of the field an id of its own. Until then, {} is left out of the "
                         "tracks.",
                         conflict.address),
         .page = "",
         .camera = std::nullopt,
         .about = fmt::format("{} {}", conflict.camera, conflict.address)});
  }
  const LeftOut& left_out = facts.left_out;
  if (left_out.camera < 0 || facts.now_s - left_out.t_s > kLately_s) return;
  if (left_out.why == LeftOut::Why::kTime) {
    report.alerts.push_back(
        {.id = "camera_off_time",
         .check = "agreement",
         .severity = Severity::kWarn,
         .title = fmt::format("Camera {} is left out of the tracks: the time of its images is far from this "
                              "computer's",
                              left_out.camera),
         .fix = "Set the clocks of all computers of this field by one time server (NTP or PTP).",
         .page = "",
         .camera = left_out.camera});
  } else if (left_out.why == LeftOut::Why::kTooMany) {
    report.alerts.push_back(
        {.id = "cameras_too_many",
         .check = "agreement",
         .severity = Severity::kWarn,
         .title = fmt::format("Camera {} is left out of the tracks: at most {} cameras are "
                              "tracked",
                              left_out.camera, Gather::kMaxCameras),
         .fix = "Find out who else sends to the vision group, or set "
                "field/other_computers to off.",
         .page = "#/settings/field"});
  }
}

}  // namespace sslv
