// SPDX-License-Identifier: Apache-2.0
#include "services/verdict/coverage.h"

#include "vision/mask.h"

#include <algorithm>

namespace sslv {
namespace {

bool looks_at(const CameraNow& camera, const Eigen::Vector2d& place_mm) {
  const CameraContext& context = camera.context();
  const CameraCalibration& calibration = context.scene->camera->calibration();
  const auto pixel = context.scene->camera->project({place_mm.x(), place_mm.y(), 0});
  return pixel && pixel->x() >= 0 && pixel->y() >= 0 && pixel->x() < calibration.pixel_image_width &&
         pixel->y() < calibration.pixel_image_height && context.looked_at().shows(pixel->x(), pixel->y());
}

/// Whether the camera's masks hide an image of this size completely.
bool is_blind(const CameraNow& camera, int width_px, int height_px) {
  constexpr int kSteps = 64;
  const Mask& mask = camera.context().looked_at();
  for (int i = 0; i < kSteps; ++i) {
    for (int k = 0; k < kSteps; ++k) {
      if (mask.shows((i + 0.5) * width_px / kSteps, (k + 0.5) * height_px / kSteps)) return false;
    }
  }
  return true;
}

}  // namespace

Coverage coverage_of(std::span<const CameraNow> cameras, const FieldSize& field) {
  Coverage out;
  out.is_known = !cameras.empty() && std::ranges::all_of(cameras, [](const CameraNow& camera) {
    return camera.context().scene->camera.has_value();
  });
  for (const CameraNow& camera : cameras) {
    if (camera.health.state != CameraState::kRunning) continue;
    const auto& calibrated = camera.context().scene->camera;
    const int width_px = camera.health.width > 0 ? camera.health.width
                         : calibrated            ? calibrated->calibration().pixel_image_width
                                                 : 0;
    const int height_px = camera.health.height > 0 ? camera.health.height
                          : calibrated             ? calibrated->calibration().pixel_image_height
                                                   : 0;
    if (width_px > 0 && is_blind(camera, width_px, height_px)) out.blind.push_back(camera.id);
  }
  if (!out.is_known) return out;
  for (int x = -field.field_length / 2 + Coverage::kGridMm / 2; x < field.field_length / 2;
       x += Coverage::kGridMm) {
    for (int y = -field.field_width / 2 + Coverage::kGridMm / 2; y < field.field_width / 2;
         y += Coverage::kGridMm) {
      const Eigen::Vector2d place(x, y);
      ++out.places;
      bool is_covered = false, is_in_reach = false;
      for (const CameraNow& camera : cameras) {
        if (!looks_at(camera, place)) continue;
        is_in_reach = true;
        is_covered = is_covered || camera.health.state == CameraState::kRunning;
      }
      if (!is_covered) out.uncovered_mm.push_back(place);
      if (!is_in_reach) out.out_of_reach_mm.push_back(place);
    }
  }
  return out;
}

}  // namespace sslv
