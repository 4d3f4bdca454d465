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

SimulatorMotions SimulatedWorld::motions_at(double t_s, double reach_s) const {
  std::array<SimulatedScene, 3> moments;
  expose(t_s, 3 * reach_s, moments);
  const auto& [before, now, after] = moments;
  const auto motion = [&](const auto& a, const auto& b, const auto& c, double turn_ab, double turn_bc) {
    const auto rate = [&](double to, double from) { return (to - from) / (2 * reach_s); };
    const auto change = [&](double first, double second) { return (second - first) / (reach_s * reach_s); };
    return SimulatorMotion{rate(c.x_mm, a.x_mm),
                           rate(c.y_mm, a.y_mm),
                           (turn_ab + turn_bc) / (2 * reach_s),
                           change(b.x_mm - a.x_mm, c.x_mm - b.x_mm),
                           change(b.y_mm - a.y_mm, c.y_mm - b.y_mm),
                           change(turn_ab, turn_bc)};
  };
  SimulatorMotions out;
  for (std::size_t i = 0; i < now.robots.size(); ++i) {
    const SimulatedRobot &a = before.robots[i], &b = now.robots[i], &c = after.robots[i];
    out.robots.push_back(motion(a, b, c, normalized(b.orientation_rad - a.orientation_rad),
                                normalized(c.orientation_rad - b.orientation_rad)));
  }
  for (std::size_t i = 0; i < now.balls.size(); ++i)
    out.balls.push_back(motion(before.balls[i], now.balls[i], after.balls[i], 0, 0));
  return out;
}

}  // namespace sslv
