// SPDX-License-Identifier: Apache-2.0
#include "vision/robot_memory.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sslv {
namespace {
/// Robots are not faster than this: a faster object is another robot, or the same robot placed elsewhere.
constexpr double kFastestRobotMmS = 8000;

/// Whether a robot may be in this state. A recording may contain any values, and sums and products of huge
/// values are unpredictable.
bool is_possible(const RobotMemory::Entry& entry) {
  constexpr double kFar = 1e7, kMaxInterval_s = 1e4;
  for (const double value :
       {entry.x_mm, entry.y_mm, entry.orientation_rad, entry.x_mm_s, entry.y_mm_s, entry.turn_rad_s}) {
    if (!(std::abs(value) < kFar)) return false;
  }
  // Between two images at almost the same time, accelerations are large.
  constexpr double kMaxChange = 1e15;
  for (const double value : {entry.x_mm_s2, entry.y_mm_s2, entry.turn_rad_s2}) {
    if (!(std::abs(value) < kMaxChange)) return false;
  }
  return std::abs(entry.interval_s) < kMaxInterval_s &&
         std::abs(entry.seen_s - entry.frame_s) < kMaxInterval_s;
}
}  // namespace

void RobotMemory::forget(double now_s, double keep_s) noexcept {
  std::erase_if(entries_, [&](const Entry& entry) {
    return entry.seen_s >= now_s || now_s - entry.seen_s > keep_s || !is_possible(entry);
  });
}

void RobotMemory::remember(const RobotList& robots, double now_s, const RowTimes& rows) noexcept {
  for (const Robot& robot : robots.robots) {
    const auto known = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) {
      return entry.team == robot.team && entry.id == robot.id;
    });
    Entry now{
        robot.team, static_cast<std::uint8_t>(robot.id), robot.x_mm, robot.y_mm, robot.orientation_rad, 0, 0,
        0,          now_s + rows.delay_s(robot.pixel_y), now_s};
    if (known == entries_.end()) {
      entries_.push_back(now);
      continue;
    }
    if (known->frame_s == now_s) continue;  // a duplicate follows the better detection
    const double dt = now.seen_s - known->seen_s;
    const double dx = robot.x_mm - known->x_mm, dy = robot.y_mm - known->y_mm;
    if (dt > 0 && std::hypot(dx, dy) < kFastestRobotMmS * dt) {
      now.x_mm_s = dx / dt;
      now.y_mm_s = dy / dt;
      now.turn_rad_s =
          std::remainder(robot.orientation_rad - known->orientation_rad, 2 * std::numbers::pi) / dt;
      now.interval_s = dt;
      if (known->interval_s > 0) {
        const double between = (dt + known->interval_s) / 2;
        now.x_mm_s2 = (now.x_mm_s - known->x_mm_s) / between;
        now.y_mm_s2 = (now.y_mm_s - known->y_mm_s) / between;
        now.turn_rad_s2 = (now.turn_rad_s - known->turn_rad_s) / between;
      }
    }
    if (dt > 0) *known = now;
  }
}

void RobotMemory::move_to_frame(RobotList& robots) const noexcept {
  for (Robot& robot : robots.robots) {
    const auto known = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) {
      return entry.team == robot.team && entry.id == robot.id && entry.x_mm == robot.x_mm &&
             entry.y_mm == robot.y_mm;
    });
    if (known == entries_.end()) continue;
    const PatternPose there = known->at_frame();
    robot.x_mm = there.x_mm;
    robot.y_mm = there.y_mm;
    robot.orientation_rad = std::remainder(there.angle_rad, 2 * std::numbers::pi);
  }
}

}  // namespace sslv
