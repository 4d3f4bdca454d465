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

/// What things are painted with: the labels' colours, and these.
namespace paint {
inline constexpr std::uint8_t kRed = label::kCount, kPurple = kRed + 1, kBrown = kRed + 2, kSkin = kRed + 3,
                              kCount = kRed + 4;
}

struct SimulatedRobot {
  Team team;
  int id;
  double x_mm, y_mm, orientation_rad, height_mm;  // as in Robot (vision/detections.h)
  std::optional<int> covered_dot{};               // this side dot is as black as the top
};
struct SimulatedBall {
  double x_mm, y_mm;
};
/// A thing that lies flat on the carpet. An orange or red one is never as long and wide as a ball, so a
/// detector that takes it for one is wrong.
struct SimulatedDistractor {
  enum class Shape : std::uint8_t { kEllipse, kRectangle, kTriangle };  // discs and stripes are among these
  Shape shape;
  std::uint8_t paint;
  double x_mm, y_mm, turn_rad;
  double length_mm, width_mm;  // along its own axes
};

/// Where everything is at one moment.
struct SimulatedScene {
  static constexpr std::size_t kMaxRobots = 32, kMaxBalls = 10, kMaxDistractors = 60;
  boost::container::static_vector<SimulatedRobot, kMaxRobots> robots;
  boost::container::static_vector<SimulatedBall, kMaxBalls> balls;
  boost::container::static_vector<SimulatedDistractor, kMaxDistractors> distractors;
};

/// How a thing moves on from where it is.
struct SimulatorMotion {
  double x_mm_s, y_mm_s, turn_rad_s;
  double x_mm_s2 = 0, y_mm_s2 = 0, turn_rad_s2 = 0;

  Eigen::Vector2d way_mm(double dt_s) const {
    return {(x_mm_s + x_mm_s2 * dt_s / 2) * dt_s, (y_mm_s + y_mm_s2 * dt_s / 2) * dt_s};
  }
  double turn_rad(double dt_s) const { return (turn_rad_s + turn_rad_s2 * dt_s / 2) * dt_s; }
};
/// How everything moves; in the order of the scene's lists.
struct SimulatorMotions {
  boost::container::static_vector<SimulatorMotion, SimulatedScene::kMaxRobots> robots;
  boost::container::static_vector<SimulatorMotion, SimulatedScene::kMaxBalls> balls;
};

/// Where everything is dt_s later.
SimulatedScene moved(const SimulatedScene& scene, const SimulatorMotions& motions, double dt_s);

/// A robot's outline is round but for its flat front.
inline constexpr double kRobotFrontPerRadius = 55.0 / 90;

/// Whether a robot, a prism from the floor to its top, hides a point lower than its top from an eye above.
bool hides(const SimulatedRobot& robot, double robot_radius_mm, const Eigen::Vector3d& point_mm,
           const Eigen::Vector3d& eye_mm);

/// Evenly spread over the unit disc.
const std::array<Eigen::Vector2d, 256>& points_of_disc();

// ---- what both placements need

/// Least gap between any two things, but for those that a placement names.
inline constexpr double kSimulatorClearanceMm = 8;

template <class T>
using PerRobot = boost::container::static_vector<T, SimulatedScene::kMaxRobots>;
using SimulatedRoster = PerRobot<std::pair<Team, int>>;  // team and id

SimulatedRoster roster_of(const SimulatorOptions& options);

/// Which image it is that has its time at the Unix time t_s.
std::int64_t picture_number(const SimulatorOptions& options, double t_s);

/// For each robot the side dot of it that is covered, if any: `covered` of them, at random.
PerRobot<std::optional<int>> choose_covered_dots(std::size_t robots, int covered, SimulatorRandom& random);

/// A distractor at the field's centre.
SimulatedDistractor make_distractor(SimulatorRandom& random);

/// The same angle in (-pi, pi].
double normalized(double angle_rad);

/// For things that do not fit on the field; `key` is the option that asked for them.
SettingsError no_room(std::string_view key, const SimulatorOptions& options, const FieldSize& field);

template <class List>
void shuffle(List& list, SimulatorRandom& random) {
  for (std::size_t i = list.size(); i > 1; --i) std::swap(list[i - 1], list[random.bits() % i]);
}

}  // namespace sslv
