// SPDX-License-Identifier: Apache-2.0
#include "capture/simulator/simulator_world.h"

#include <cstddef>
#include <optional>

namespace sslv {
namespace {

using Placement = std::variant<SimulatorPaths, SimulatorScatter>;

Placement make_placement(const SimulatorOptions& options, const FieldSize& field,
                         const std::array<double, 2>& robot_height_mm, const CameraModel* camera) {
  if (options.placement == SimulatorPlacement::kPaths) return SimulatorPaths(options, field, robot_height_mm);
  return SimulatorScatter(options, field, robot_height_mm,
                          camera != nullptr ? std::optional(*camera) : std::nullopt);
}

}  // namespace

SimulatedWorld::SimulatedWorld(const SimulatorOptions& options, const FieldSize& field,
                               const std::array<double, 2>& robot_height_mm, const CameraModel* camera)
    : placement_(make_placement(options, field, robot_height_mm, camera)) {}

SimulatedScene SimulatedWorld::at(double t_s) const {
  if (const auto* paths = std::get_if<SimulatorPaths>(&placement_)) return paths->at(t_s);
  return std::get<SimulatorScatter>(placement_).slot_at(t_s).scene;
}

void SimulatedWorld::expose(double t_s, double exposure_s, std::span<SimulatedScene> moments) const {
  const auto offset_s = [&](std::size_t i) {
    return ((static_cast<double>(i) + 0.5) / static_cast<double>(moments.size()) - 0.5) * exposure_s;
  };
  if (const auto* paths = std::get_if<SimulatorPaths>(&placement_)) {
    for (std::size_t i = 0; i < moments.size(); ++i) moments[i] = paths->at(t_s + offset_s(i));
    return;
  }
  const SimulatorSlot slot = std::get<SimulatorScatter>(placement_).slot_at(t_s);
  for (std::size_t i = 0; i < moments.size(); ++i) moments[i] = slot.at(offset_s(i));
}

}  // namespace sslv
