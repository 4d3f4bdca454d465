// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geometry/limits.h"
#include "tracking/tracks.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sslv {

/// A TrackedField in one block of memory, which can be read while the field's thread continues.
struct FieldNow {
  struct Robot {
    double x_mm, y_mm, vx_mm_s, vy_mm_s, orientation_rad, turn_rad_s, sigma_mm, visibility;
    int team, id;
  };
  struct Ball {
    double x_mm, y_mm, z_mm, vx_mm_s, vy_mm_s, vz_mm_s, visibility;
  };
  struct Kick {
    double t_s, x_mm, y_mm, vx_mm_s, vy_mm_s, vz_mm_s, landing_x_mm, landing_y_mm;
    int number;    // 0: none
    int team, id;  // the robot that kicked; id -1: unknown
    bool is_chip;
  };
  static constexpr std::size_t kMaxRobots = limits::kMaxRobots, kMaxBalls = 8, kKicks = 8;

  double t_s = 0;
  std::uint32_t number = 0;  // 0: nothing was tracked yet
  std::uint32_t robot_count = 0, ball_count = 0;
  std::array<Robot, kMaxRobots> robots{};
  std::array<Ball, kMaxBalls> balls{};
  std::array<Kick, kKicks> kicks{};  // the newest kicks; kick n is at index n % kKicks
};

/// Copies `tracked` to `out`, and adds its kick to the earlier kicks there.
void write_now(const TrackedField& tracked, FieldNow& out) noexcept;

TrackedField tracked_of(const FieldNow& now);
/// Sorted by number, the newest kick last.
std::vector<TrackedKick> kicks_of(const FieldNow& now);

}  // namespace sslv
