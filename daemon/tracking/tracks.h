// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geometry/scene.h"

#include <cstdint>
#include <optional>
#include <tuple>
#include <vector>

#include <Eigen/Core>

namespace sslv {

/// Identifies a robot on the field.
struct RobotName {
  Team team = Team::kYellow;
  int id = 0;
  bool operator==(const RobotName& other) const = default;
  bool operator<(const RobotName& other) const { return std::tie(team, id) < std::tie(other.team, other.id); }
};

/// Estimate of a robot at one time.
struct TrackedRobot {
  RobotName name;
  Eigen::Vector2d place_mm{0, 0}, velocity_mm_s{0, 0};
  double orientation_rad = 0, turn_rad_s = 0;
  double place_sigma_mm = 0;
  double visibility = 0;  // 0 .. 1: falls while no camera sees the robot
};

/// Estimate of a ball at one time; the position is the ball's centre.
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
  Eigen::Vector2d landing_mm{0, 0};  // landing point of a chip
  double stop_s = 0;                 // time at which the ball will stop if it hits nothing
  Eigen::Vector2d stop_mm{0, 0};     // position at which the ball will stop
  std::optional<RobotName> robot;
};

/// All tracked objects at one time.
struct TrackedField {
  std::uint32_t number = 0;  // counts published fields
  double t_s = 0;            // Unix time
  std::vector<TrackedRobot> robots;
  std::vector<TrackedBall> balls;  // the first is the ball in play
  std::optional<TrackedKick> kick;
  std::uint64_t repaired = 0;  // number of filters reset because they were not finite
};

}  // namespace sslv
