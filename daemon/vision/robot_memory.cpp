// SPDX-License-Identifier: Apache-2.0
#include "vision/robot_memory.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sslv {
namespace {
/// Robots do not drive faster: what seems to is another one, or the same put elsewhere.
constexpr double kFastestMmS = 8000;
}  // namespace

void RobotMemory::forget(double now_s, double keep_s) noexcept {
  std::erase_if(entries_,
                [&](const Entry& entry) { return entry.seen_s >= now_s || now_s - entry.seen_s > keep_s; });
}

void RobotMemory::remember(const RobotList& robots, double now_s) noexcept {
  for (const Robot& robot : robots.robots) {
    const auto known = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) {
      return entry.team == robot.team && entry.id == robot.id;
    });
    Entry now{robot.team, robot.id, robot.x_mm, robot.y_mm, robot.orientation_rad, 0, 0, 0, now_s};
    if (known == entries_.end()) {
      entries_.push_back(now);
      continue;
    }
    const double dt = now_s - known->seen_s;
    const double dx = robot.x_mm - known->x_mm, dy = robot.y_mm - known->y_mm;
    if (dt > 0 && std::hypot(dx, dy) < kFastestMmS * dt) {
      now.x_mm_s = dx / dt;
      now.y_mm_s = dy / dt;
      now.turn_rad_s = std::remainder(robot.orientation_rad - known->orientation_rad, 2 * std::numbers::pi) / dt;
    }
    if (dt > 0) *known = now;  // a duplicate comes after the better one
  }
}

}  // namespace sslv
