// SPDX-License-Identifier: Apache-2.0
#include "services/colors/color_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sslv {
namespace {

void add_margin_alert(std::vector<Alert>& alerts, const ColorFacts& camera) {
  if (!camera.min_margin || camera.min_margin->share >= kWantedMargin) return;
  alerts.push_back(
      {.id = "margin_thin",
       .check = "colors",
       .severity = camera.min_margin->share < kMinMargin ? Severity::kBad : Severity::kWarn,
       .title = fmt::format("Camera {}: {}", camera.camera_id, camera.min_margin->text),
       .fix = "A small change of light can hide robots: widen the margins, or learn the colours again.",
       .page = fmt::format("#/colours/{}", camera.camera_id),
       .camera = camera.camera_id});
}

void add_empty_alert(std::vector<Alert>& alerts, const ColorFacts& camera) {
  if (camera.missing_labels.empty()) return;
  alerts.push_back(
      {.id = "colors_missing",
       .check = "colors",
       .severity = Severity::kBad,
       .title = fmt::format("Camera {}: the colour table has no {}", camera.camera_id,
                            fmt::join(camera.missing_labels, ", no ")),
       .fix = "Nothing of that colour can be found: learn the colours, import a table, or undo the change.",
       .page = fmt::format("#/colours/{}", camera.camera_id),
       .camera = camera.camera_id});
}

void add_swapped_alert(std::vector<Alert>& alerts, const ColorFacts& camera) {
  if (camera.swapped_labels.empty()) return;
  alerts.push_back(
      {.id = "colors_swapped",
       .check = "colors",
       .severity = Severity::kBad,
       .title = fmt::format("Camera {}: the colour table mistakes {}", camera.camera_id,
                            fmt::join(camera.swapped_labels, " and ")),
       .fix = "Robots get other ids or teams: learn the colours again, import a table, or undo the change.",
       .page = fmt::format("#/colours/{}", camera.camera_id),
       .camera = camera.camera_id});
}

void add_grey_alert(std::vector<Alert>& alerts, const ColorFacts& camera) {
  if (camera.grey_format.empty()) return;
  alerts.push_back(
      {.id = "images_grey",
       .check = "colors",
       .severity = Severity::kBad,
       .title =
           fmt::format("Camera {} sends images without colours ({})", camera.camera_id, camera.grey_format),
       .fix = "No robot and no ball can be found: choose a format with colours in its source (pixel_format).",
       .page = "#/settings/cameras",
       .camera = camera.camera_id});
}

Check check_colors(std::span<const ColorFacts> cameras) {
  const ColorFacts::Margin* least = nullptr;
  for (const ColorFacts& camera : cameras) {
    if (camera.min_margin && (!least || camera.min_margin->share < least->share)) least = &*camera.min_margin;
  }
  Check check{"colors",  "Colours", CheckState::kUnknown,
              kNoFigure, "",        "margins to the carpet are not known yet"};
  if (!least) return check;
  check.state = CheckState::kPass;
  const bool is_limited = least->share < ColorFacts::Margin::kMax;
  check.value = fmt::format("{}{:.0f}", is_limited ? "" : "> ", 100 * least->share);
  check.unit = "% margin";
  check.text = least->text.empty() ? "the carpet stays clear" : least->text;
  return check;
}

}  // namespace

void report_colors(std::span<const ColorFacts> cameras, const std::vector<std::string>& lost_tables,
                   HealthReport& report) {
  for (const ColorFacts& camera : cameras) add_grey_alert(report.alerts, camera);
  for (const ColorFacts& camera : cameras) add_empty_alert(report.alerts, camera);
  for (const ColorFacts& camera : cameras) add_swapped_alert(report.alerts, camera);
  for (const ColorFacts& camera : cameras) add_margin_alert(report.alerts, camera);
  for (const std::string& problem : lost_tables) {
    report.alerts.push_back(
        {.id = "table_lost",
         .check = "pictures",
         .severity = Severity::kWarn,
         .title = problem,
         .fix =
             "The camera uses the table of its settings' classes or file. Learn its colours, import a table, "
             "or undo a step of the settings' history.",
         .page = "#/colours"});
  }
  report.checks.push_back(check_colors(cameras));
}

}  // namespace sslv
