// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/simulator_options.h"
#include "geometry/scene.h"

#include <array>
#include <vector>

#include <boost/container/static_vector.hpp>

namespace sslv {

struct SimulatedRobot {
  Team team;
  int id;
  double x_mm, y_mm, orientation_rad, height_mm;  // as in Robot (vision/detections.h)
};
struct SimulatedBall {
  double x_mm, y_mm;
};

/// Where everything is at one moment. Robots and balls keep their places in the lists for all times.
struct SimulatedScene {
  static constexpr std::size_t kMaxRobots = 32, kMaxBalls = 10;
  boost::container::static_vector<SimulatedRobot, kMaxRobots> robots;
  boost::container::static_vector<SimulatedBall, kMaxBalls> balls;
};

/// Robots and balls in endless smooth motion on the field: a function of the options and the time alone, so
/// that all cameras with the same options agree and a test knows the truth.
///
/// Everything moves in a disc that is then stretched to the field, which only takes things further apart:
/// robots drive round on rings, balls in the lanes between them. So nothing ever touches.
class SimulatedWorld {
 public:
  static constexpr double kClearanceMm = 8;  // least gap between any two things

  /// Throws SettingsError when there is no room for all of them.
  SimulatedWorld(const SimulatorOptions& options, const FieldSize& field,
                 const std::array<double, 2>& robot_height_mm);

  /// Everything's place at a Unix time. Orientations are in (-pi, pi].
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
  };
  struct Point {
    double x_mm, y_mm, travel_rad;
  };
  Point on_field(const Orbit& orbit, double t_s) const;

  double speed_;
  double stretch_x_, stretch_y_;
  std::array<double, 2> robot_height_mm_;
  std::vector<Driver> drivers_;
  std::vector<Orbit> balls_;
};

}  // namespace sslv
