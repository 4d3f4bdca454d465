// SPDX-License-Identifier: Apache-2.0
#include "services/verdict/coverage.h"

#include "vision/mask.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

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

Eigen::Vector2d middle_of_largest(const std::vector<Eigen::Vector2d>& places_mm) {
  using Cell = std::pair<int, int>;
  std::map<Cell, Eigen::Vector2d> left;
  for (const Eigen::Vector2d& place : places_mm) {
    left.emplace(Cell{static_cast<int>(std::floor(place.x() / Coverage::kGridMm)),
                      static_cast<int>(std::floor(place.y() / Coverage::kGridMm))},
                 place);
  }
  std::vector<Eigen::Vector2d> largest;
  while (!left.empty()) {
    std::vector<Eigen::Vector2d> group;
    std::vector<Cell> next{left.begin()->first};
    while (!next.empty()) {
      const Cell cell = next.back();
      next.pop_back();
      const auto found = left.find(cell);
      if (found == left.end()) continue;
      group.push_back(found->second);
      left.erase(found);
      for (const int step : {-1, 1}) {
        next.emplace_back(cell.first + step, cell.second);
        next.emplace_back(cell.first, cell.second + step);
      }
    }
    if (group.size() > largest.size()) largest = std::move(group);
  }
  Eigen::Vector2d sum(0, 0);
  for (const Eigen::Vector2d& place : largest) sum += place;
  const Eigen::Vector2d middle = sum / static_cast<double>(largest.size());
  return *std::ranges::min_element(largest, {}, [&](const auto& place) { return (place - middle).norm(); });
}

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
