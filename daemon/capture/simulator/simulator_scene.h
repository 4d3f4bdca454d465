// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/error.h"
#include "capture/simulator/simulator_options.h"
#include "capture/simulator/simulator_random.h"
#include "geometry/field.h"
#include "geometry/scene.h"
#include "vision/label.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

#include <Eigen/Core>
#include <boost/container/static_vector.hpp>

namespace sslv {

/// Colours of things, in addition to the colours of the labels.
namespace paint {
inline constexpr std::uint8_t kRed = label::kCount, kPurple = kRed + 1, kBrown = kRed + 2, kSkin = kRed + 3,
                              kCount = kRed + 4;
}

struct SimulatedRobot {
  Team team;
  int id;
  double x_mm, y_mm, orientation_rad, height_mm;  // as in Robot (vision/detections.h)
  std::optional<int> covered_dot{};               // this side dot is black like the top
};
struct SimulatedBall {
  double x_mm, y_mm;
};
/// A flat thing on the carpet. An orange or red distractor never has both the length and the width of a ball,
/// so a detector that reports it as a ball is wrong.
struct SimulatedDistractor {
  enum class Shape : std::uint8_t { kEllipse, kRectangle, kTriangle };  // include discs and stripes
  Shape shape;
  std::uint8_t paint;
  double x_mm, y_mm, turn_rad;
  double length_mm, width_mm;  // along its own axes
};

/// The positions of all things at one moment.
struct SimulatedScene {
  static constexpr std::size_t kMaxRobots = 32, kMaxBalls = 10, kMaxDistractors = 60;
  boost::container::static_vector<SimulatedRobot, kMaxRobots> robots;
  boost::container::static_vector<SimulatedBall, kMaxBalls> balls;
  boost::container::static_vector<SimulatedDistractor, kMaxDistractors> distractors;
};

/// Motion of a thing from its current position.
struct SimulatorMotion {
  double x_mm_s, y_mm_s, turn_rad_s;
  double x_mm_s2 = 0, y_mm_s2 = 0, turn_rad_s2 = 0;

  Eigen::Vector2d way_mm(double dt_s) const {
    return {(x_mm_s + x_mm_s2 * dt_s / 2) * dt_s, (y_mm_s + y_mm_s2 * dt_s / 2) * dt_s};
  }
  double turn_rad(double dt_s) const { return (turn_rad_s + turn_rad_s2 * dt_s / 2) * dt_s; }
};
/// Motion of all things, in the order of the scene's lists.
struct SimulatorMotions {
  boost::container::static_vector<SimulatorMotion, SimulatedScene::kMaxRobots> robots;
  boost::container::static_vector<SimulatorMotion, SimulatedScene::kMaxBalls> balls;
};

/// The scene dt_s later.
SimulatedScene moved(const SimulatedScene& scene, const SimulatorMotions& motions, double dt_s);

/// A robot's outline is a circle with a flat front.
inline constexpr double kRobotFrontPerRadius = 55.0 / 90;

/// Whether a robot, a prism from the floor to its top, hides a point below its top from an eye above it.
bool hides(const SimulatedRobot& robot, double robot_radius_mm, const Eigen::Vector3d& point_mm,
           const Eigen::Vector3d& eye_mm);

/// Points evenly spread over the unit disc.
const std::array<Eigen::Vector2d, 256>& points_of_disc();

// ---- shared by both placements

/// Minimum gap between any two things, unless a placement defines another.
inline constexpr double kSimulatorClearanceMm = 8;

template <class T>
using PerRobot = boost::container::static_vector<T, SimulatedScene::kMaxRobots>;
using SimulatedRoster = PerRobot<std::pair<Team, int>>;  // team and id

SimulatedRoster roster_of(const SimulatorOptions& options);

/// Number of the image whose time is Unix time t_s.
std::int64_t picture_number(const SimulatorOptions& options, double t_s);

/// The covered side dot of each robot. `covered` robots, chosen at random, have a covered dot, the other
/// robots none.
PerRobot<std::optional<int>> choose_covered_dots(std::size_t robots, int covered, SimulatorRandom& random);

/// A distractor at the field's centre.
SimulatedDistractor make_distractor(SimulatorRandom& random);

/// The equivalent angle in (-pi, pi].
double normalized(double angle_rad);

/// The error for things that do not fit on the field; `key` is the option that requested them.
SettingsError no_room(std::string_view key, const SimulatorOptions& options, const FieldSize& field);

template <class List>
void shuffle(List& list, SimulatorRandom& random) {
  for (std::size_t i = list.size(); i > 1; --i) std::swap(list[i - 1], list[random.bits() % i]);
}

}  // namespace sslv
