// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/error.h"
#include "capture/simulator_options.h"
#include "capture/simulator_random.h"
#include "geometry/scene.h"
#include "vision/label.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

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
/// A thing that lies flat on the carpet. An orange or red one is never as long and wide as a ball, so whoever
/// takes it for one is wrong.
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

inline constexpr double kRobotFrontPerRadius =
    55.0 / 90;  // a robot's outline is round but for its flat front

/// Whether a robot, a prism from the floor to its top, hides a point lower than its top from an eye above.
bool hides(const SimulatedRobot& robot, double robot_radius_mm, const Eigen::Vector3d& point_mm,
           const Eigen::Vector3d& eye_mm);

/// Evenly spread over the unit disc.
const std::array<Eigen::Vector2d, 256>& points_of_disc();

/// Where everything is: a function of the options and the time alone, so that all cameras with the same
/// options agree and a test knows the truth. Distractors are under everything else.
///
/// Paths: robots and balls are in endless smooth motion and keep their places in the lists for all times;
/// distractors lie still. Everything moves in a disc that is then stretched to the field, which only takes
/// things further apart: robots drive round on rings, balls in the lanes between them. So nothing ever
/// touches.
///
/// Scatter: time is cut into slots of one frame period, and in each everything is at another random place,
/// the things of a slot apart from each other (see kClearanceMm and what follows). It moves only while a
/// picture is exposed. Should a slot have no place for something, which is rare, it is left out.
class SimulatedWorld {
 public:
  static constexpr double kClearanceMm = 8;  // least gap between any two things, but for those below
  // In scatter, to robots and other balls; the robot that a ball hides behind may be nearer.
  static constexpr double kBallClearanceMm = 60;
  // In scatter.
  static constexpr double kDistractorToBallMm = 40, kBetweenDistractorsMm = 10;

  /// Balls are hidden from `camera`, so worlds with hidden_balls are not the same for all cameras. Throws
  /// SettingsError when there is no room for all of them, or hidden_balls without a camera.
  SimulatedWorld(const SimulatorOptions& options, const FieldSize& field,
                 const std::array<double, 2>& robot_height_mm, const CameraModel* camera = nullptr);

  /// Everything's place at a Unix time. Orientations are in (-pi, pi]. In scatter, that in the slot's middle.
  SimulatedScene at(double t_s) const;

  /// The moments, evenly spread, of an exposure with its middle at t_s.
  void expose(double t_s, double exposure_s, std::span<SimulatedScene> moments) const;

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
    std::optional<int> covered_dot{};
  };
  struct Point {
    double x_mm, y_mm, travel_rad;
  };
  /// What a thing does while a slot's picture is exposed.
  struct Motion {
    double x_mm_s, y_mm_s, turn_rad_s;
  };
  struct Slot {
    SimulatedScene scene;
    boost::container::static_vector<Motion, SimulatedScene::kMaxRobots> robot_motion;
    boost::container::static_vector<Motion, SimulatedScene::kMaxBalls> ball_motion;
    const char* no_room_for = nullptr;  // option whose things did not all find a place
  };
  class Scatter;  // fills a slot

  void lay_paths(SimulatorRandom& random);
  Point on_field(const Orbit& orbit, double t_s) const;
  SimulatedScene on_paths(double t_s) const;
  Slot scattered(double t_s) const;
  Slot scattered_in_slot(std::int64_t slot) const;
  SettingsError no_room(std::string_view key) const;

  SimulatorOptions options_;
  FieldSize field_;
  std::array<double, 2> robot_height_mm_;
  std::optional<CameraModel> camera_;
  std::vector<std::pair<Team, int>> roster_;
  // Paths.
  double stretch_x_ = 1, stretch_y_ = 1;
  std::vector<Driver> drivers_;
  std::vector<Orbit> balls_;
  std::vector<SimulatedDistractor> distractors_;
};

}  // namespace sslv
