// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/simulator/simulator_scene.h"

#include <array>
#include <optional>
#include <vector>

namespace sslv {

/// Robots and balls in endless smooth motion, at constant indices in the lists; distractors lie still. Robots
/// circle on rings in a disc, and balls circle in the lanes between the rings, so that they never touch. The
/// disc is then stretched to the field, which only increases distances.
class SimulatorPaths {
 public:
  /// Throws SettingsError if there is not enough space for all robots and balls.
  SimulatorPaths(const SimulatorOptions& options, const FieldSize& field,
                 const std::array<double, 2>& robot_height_mm);

  SimulatedScene at(double t_s) const;

 private:
  /// middle + reach * sin(rate * t + phase)
  struct Swing {
    double middle, reach, rate_hz, phase;
    double at(double t_s) const;
  };
  /// A path around the disc: radius and angle oscillate about a uniform rotation.
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
