// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/simulator/simulator_scene.h"

#include <array>
#include <optional>
#include <vector>

namespace sslv {

/// Robots and balls in endless smooth motion, which keep their places in the lists for all times; distractors
/// lie still. Everything moves in a disc that is then stretched to the field, which only takes things further
/// apart: robots drive round on rings, balls in the lanes between them. So nothing ever touches.
class SimulatorPaths {
 public:
  /// Throws SettingsError when there is no room for all of them.
  SimulatorPaths(const SimulatorOptions& options, const FieldSize& field,
                 const std::array<double, 2>& robot_height_mm);

  SimulatedScene at(double t_s) const;

 private:
  /// middle + reach * sin(rate * t + phase)
  struct Swing {
    double middle, reach, rate_hz, phase;
    double at(double t_s) const;
  };
  /// A path round the disc: radius and angle swing about an even turning.
  struct Orbit {
    Swing radius_mm, angle_rad;
    double turn_rad_s;
  };
  struct Driver {
    Team team;
    int id;
    Orbit orbit;
    Swing heading_rad;  // relative to the direction of travel
    double height_mm;
    std::optional<int> covered_dot{};
  };
  struct Point {
    double x_mm, y_mm, travel_rad;
  };

  void lay_paths(const SimulatorOptions& options, const FieldSize& field, SimulatorRandom& random);
  Point on_field(const Orbit& orbit, double t_s) const;

  double speed_;
  double stretch_x_ = 1, stretch_y_ = 1;
  std::vector<Driver> drivers_;
  std::vector<Orbit> balls_;
  std::vector<SimulatedDistractor> distractors_;
};

}  // namespace sslv
