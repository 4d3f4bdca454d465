// SPDX-License-Identifier: Apache-2.0
#include "services/field/field_now.h"

#include <algorithm>

namespace sslv {

void write_now(const TrackedField& tracked, FieldNow& out) noexcept {
  out.t_s = tracked.t_s;
  out.number = tracked.number;
  out.robot_count = static_cast<std::uint32_t>(std::min(tracked.robots.size(), FieldNow::kMaxRobots));
  for (std::size_t i = 0; i < out.robot_count; ++i) {
    const TrackedRobot& robot = tracked.robots[i];
    out.robots[i] = {robot.place_mm.x(),
                     robot.place_mm.y(),
                     robot.velocity_mm_s.x(),
                     robot.velocity_mm_s.y(),
                     robot.orientation_rad,
                     robot.turn_rad_s,
                     robot.place_sigma_mm,
                     robot.visibility,
                     static_cast<int>(robot.name.team),
                     robot.name.id};
  }
  out.ball_count = static_cast<std::uint32_t>(std::min(tracked.balls.size(), FieldNow::kMaxBalls));
  for (std::size_t i = 0; i < out.ball_count; ++i) {
    const TrackedBall& ball = tracked.balls[i];
    out.balls[i] = {ball.place_mm.x(),      ball.place_mm.y(),      ball.place_mm.z(), ball.velocity_mm_s.x(),
                    ball.velocity_mm_s.y(), ball.velocity_mm_s.z(), ball.visibility};
  }
  if (!tracked.kick || tracked.kick->number <= 0) {
    out.kicks = {};  // a new tracker, without kicks so far
    return;
  }
  const TrackedKick& kick = *tracked.kick;
  out.kicks[static_cast<std::size_t>(kick.number) % FieldNow::kKicks] = {
      kick.t_s,
      kick.place_mm.x(),
      kick.place_mm.y(),
      kick.velocity_mm_s.x(),
      kick.velocity_mm_s.y(),
      kick.velocity_mm_s.z(),
      kick.landing_mm.x(),
      kick.landing_mm.y(),
      kick.number,
      kick.robot ? static_cast<int>(kick.robot->team) : 0,
      kick.robot ? kick.robot->id : -1,
      kick.is_chip};
}

TrackedField tracked_of(const FieldNow& now) {
  TrackedField out;
  out.number = now.number;
  out.t_s = now.t_s;
  for (std::size_t i = 0; i < now.robot_count; ++i) {
    const FieldNow::Robot& one = now.robots[i];
    TrackedRobot& robot = out.robots.emplace_back();
    robot.name = {static_cast<Team>(one.team), one.id};
    robot.place_mm = {one.x_mm, one.y_mm};
    robot.velocity_mm_s = {one.vx_mm_s, one.vy_mm_s};
    robot.orientation_rad = one.orientation_rad;
    robot.turn_rad_s = one.turn_rad_s;
    robot.place_sigma_mm = one.sigma_mm;
    robot.visibility = one.visibility;
  }
  for (std::size_t i = 0; i < now.ball_count; ++i) {
    const FieldNow::Ball& one = now.balls[i];
    TrackedBall& ball = out.balls.emplace_back();
    ball.place_mm = {one.x_mm, one.y_mm, one.z_mm};
    ball.velocity_mm_s = {one.vx_mm_s, one.vy_mm_s, one.vz_mm_s};
    ball.visibility = one.visibility;
  }
  const std::vector<TrackedKick> kicks = kicks_of(now);
  if (!kicks.empty()) out.kick = kicks.back();
  return out;
}

std::vector<TrackedKick> kicks_of(const FieldNow& now) {
  std::vector<TrackedKick> out;
  for (const FieldNow::Kick& one : now.kicks) {
    if (one.number == 0) continue;
    TrackedKick& kick = out.emplace_back();
    kick.number = one.number;
    kick.t_s = one.t_s;
    kick.place_mm = {one.x_mm, one.y_mm};
    kick.velocity_mm_s = {one.vx_mm_s, one.vy_mm_s, one.vz_mm_s};
    kick.is_chip = one.is_chip;
    kick.landing_mm = {one.landing_x_mm, one.landing_y_mm};
    if (one.id >= 0) kick.robot = RobotName{static_cast<Team>(one.team), one.id};
  }
  std::sort(out.begin(), out.end(),
            [](const TrackedKick& a, const TrackedKick& b) { return a.number < b.number; });
  return out;
}

}  // namespace sslv
