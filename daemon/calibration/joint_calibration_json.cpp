// SPDX-License-Identifier: Apache-2.0
#include "calibration/joint_calibration_json.h"

#include "base/params_json.h"
#include "calibration/calibration_json.h"

namespace sslv {
namespace {

Json disagreement_json(const std::optional<Disagreement>& disagreement) {
  if (!disagreement) return nullptr;
  return {{"before_mm", disagreement->before_mm}, {"after_mm", disagreement->after_mm}};
}

Json camera_json(const JointCameraReport& camera) {
  if (!camera.found) return {{"camera", camera.id}, {"found", false}};
  return {{"camera", camera.id},
          {"found", true},
          {"calibration", params_to_json(camera.calibration)},
          {"rms_px", camera.rms_px},
          {"found_share", camera.found_share},
          {"height_before_mm", camera.height_before_mm},
          {"height_mm", camera.height_mm},
          {"lens_rms_mm", camera.lens_rms_mm},
          {"moved_on_floor_mm", camera.moved_on_floor_mm},
          {"moved_at_150_mm", camera.moved_at_150_mm}};
}

}  // namespace

Json report_json(const JointReport& report) {
  Json cameras = Json::array();
  for (const JointCameraReport& camera : report.cameras) cameras.push_back(camera_json(camera));
  return {{"found", report.found},
          {"accepted", report.accepted},
          {"cameras", std::move(cameras)},
          {"lines_measured_to", name_of(report.measured)},
          {"on_floor", disagreement_json(report.on_floor)},
          {"of_robots", disagreement_json(report.of_robots)},
          {"overlapping_patches", report.overlapping_patches},
          {"ties", report.ties},
          {"notes", report.notes},
          {"problems", report.problems}};
}

Json joint_figures_json(const JointReport& report, const JointCameraReport& camera) {
  Json together = Json::array();
  for (const JointCameraReport& one : report.cameras) together.push_back(one.id);
  return {{"accepted", report.accepted},
          {"together", std::move(together)},
          {"rms_px", camera.rms_px},
          {"found_share", camera.found_share},
          {"moved_on_floor_mm", camera.moved_on_floor_mm},
          {"moved_at_150_mm", camera.moved_at_150_mm},
          {"on_floor", disagreement_json(report.on_floor)},
          {"of_robots", disagreement_json(report.of_robots)}};
}

}  // namespace sslv
