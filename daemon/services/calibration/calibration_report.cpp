// SPDX-License-Identifier: Apache-2.0
#include "services/calibration/calibration_report.h"

#include <algorithm>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

void add_alerts(std::vector<Alert>& alerts, const CalibrationFacts& camera) {
  const auto add = [&](const char* id, Severity severity, std::string title, std::string fix) {
    alerts.push_back({.id = id,
                      .check = "calibration",
                      .severity = severity,
                      .title = std::move(title),
                      .fix = std::move(fix),
                      .page = fmt::format("#/calibration/{}", camera.camera_id),
                      .camera = camera.camera_id});
  };
  const auto& made = camera.calibration;
  if (!made) {
    add("not_calibrated", Severity::kBad, fmt::format("Camera {} is not calibrated", camera.camera_id),
        "Nothing that it sees can be located: calibrate it.");
    return;
  }
  if (camera.width_px > 0 &&
      (camera.width_px != made->pixel_image_width || camera.height_px != made->pixel_image_height)) {
    add("calibration_other_size", Severity::kBad,
        fmt::format("Camera {} sends {}x{} pixels, its calibration was made for {}x{}", camera.camera_id,
                    camera.width_px, camera.height_px, made->pixel_image_width, made->pixel_image_height),
        "All positions are wrong: restore the old image size, or calibrate again.");
  }
  if (camera.field_changed) {
    add("calibration_stale", Severity::kWarn,
        fmt::format("The field was changed after camera {} was calibrated on it", camera.camera_id),
        "Calibrate it again, or restore the sizes that the field had then.");
  }
}

}  // namespace

void report_calibrations(std::span<const CalibrationFacts> cameras, HealthReport& report) {
  for (const CalibrationFacts& camera : cameras) add_alerts(report.alerts, camera);
  const auto count = std::count_if(cameras.begin(), cameras.end(), [](const CalibrationFacts& camera) {
    return camera.calibration.has_value();
  });
  report.checks.push_back({"calibration", "Calibration",
                           cameras.empty() ? CheckState::kUnknown : CheckState::kPass, std::to_string(count),
                           fmt::format("of {}", cameras.size()),
                           cameras.empty() ? "there is no camera" : "all calibrated"});
}

}  // namespace sslv
