// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geometry/scene.h"

#include <cstdint>
#include <optional>
#include <tuple>
#include <vector>

#include <Eigen/Core>

namespace sslv {

/// Which robot, of all on the field.
struct RobotName {
  Team team = Team::kYellow;
  int id = 0;
  bool operator==(const RobotName& other) const = default;
  bool operator<(const RobotName& other) const { return std::tie(team, id) < std::tie(other.team, other.id); }
};

/// A robot at one moment, as far as is known.
struct TrackedRobot {
  RobotName name;
  Eigen::Vector2d place_mm{0, 0}, velocity_mm_s{0, 0};
  double orientation_rad = 0, turn_rad_s = 0;
  double place_sigma_mm = 0;
  double visibility = 0;  // 0 .. 1: falls while no camera sees it
};

/// A ball at one moment; its place is that of its centre.
struct TrackedBall {
  Eigen::Vector3d place_mm{0, 0, 0}, velocity_mm_s{0, 0, 0};
  double visibility = 0;
};

/// The newest kick.
struct TrackedKick {
  int number = 0;  // counted from 1
  double t_s = 0;
  Eigen::Vector2d place_mm{0, 0};
  Eigen::Vector3d velocity_mm_s{0, 0, 0};
  bool is_chip = false;
  Eigen::Vector2d landing_mm{0, 0};  // of a chip
  double stop_s = 0;                 // when the ball will lie still, if nothing meets it
  Eigen::Vector2d stop_mm{0, 0};     // and where
  std::optional<RobotName> robot;
};

/// All that is tracked, at one moment.
struct TrackedField {
  std::uint32_t number = 0;  // counts what was published
  double t_s = 0;            // Unix time
  std::vector<TrackedRobot> robots;
  std::vector<TrackedBall> balls;  // the first is the one that is played
  std::optional<TrackedKick> kick;
  std::uint64_t repaired = 0;  // filters that were not finite and were reset, since tracking began
};

}  // namespace sslv
