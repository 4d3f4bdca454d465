// SPDX-License-Identifier: Apache-2.0
#include "services/field/field_now.h"

#include <algorithm>
#include <cmath>

namespace sslv {
namespace {

const char* name_of(int team) {
  return team == static_cast<int>(Team::kYellow) ? "yellow" : "blue";
}

/// Viewers need no more, and bad Wi-Fi takes no more.
double to_tenths(double value) {
  return std::round(value * 10) / 10;
}
double to_thousandths(double value) {
  return std::round(value * 1000) / 1000;
}

}  // namespace

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
  if (!tracked.kick || tracked.kick->number <= 0) return;
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

Json to_json(const FieldNow::Kick& kick) {
  Json out{{"number", kick.number},
           {"time", kick.t_s},
           {"x", to_tenths(kick.x_mm)},
           {"y", to_tenths(kick.y_mm)},
           {"vx", to_tenths(kick.vx_mm_s)},
           {"vy", to_tenths(kick.vy_mm_s)},
           {"vz", to_tenths(kick.vz_mm_s)},
           {"speed_m_s", to_thousandths(std::hypot(kick.vx_mm_s, kick.vy_mm_s, kick.vz_mm_s) * 1e-3)},
           {"is_chip", kick.is_chip},
           {"landing", nullptr},
           {"robot", nullptr}};
  if (kick.is_chip) out["landing"] = {to_tenths(kick.landing_x_mm), to_tenths(kick.landing_y_mm)};
  if (kick.id >= 0) out["robot"] = {{"team", name_of(kick.team)}, {"id", kick.id}};
  return out;
}

Json to_json(const FieldNow& now) {
  Json out{{"number", now.number}, {"time", now.t_s}, {"robots", Json::array()}, {"balls", Json::array()}};
  for (std::size_t i = 0; i < now.robot_count; ++i) {
    const FieldNow::Robot& robot = now.robots[i];
    out["robots"].push_back({{"team", name_of(robot.team)},
                             {"id", robot.id},
                             {"x", to_tenths(robot.x_mm)},
                             {"y", to_tenths(robot.y_mm)},
                             {"vx", to_tenths(robot.vx_mm_s)},
                             {"vy", to_tenths(robot.vy_mm_s)},
                             {"orientation", to_thousandths(robot.orientation_rad)},
                             {"turn_rad_s", to_thousandths(robot.turn_rad_s)},
                             {"sigma_mm", to_tenths(robot.sigma_mm)},
                             {"visibility", to_thousandths(robot.visibility)}});
  }
  for (std::size_t i = 0; i < now.ball_count; ++i) {
    const FieldNow::Ball& ball = now.balls[i];
    out["balls"].push_back({{"x", to_tenths(ball.x_mm)},
                            {"y", to_tenths(ball.y_mm)},
                            {"z", to_tenths(ball.z_mm)},
                            {"vx", to_tenths(ball.vx_mm_s)},
                            {"vy", to_tenths(ball.vy_mm_s)},
                            {"vz", to_tenths(ball.vz_mm_s)},
                            {"visibility", to_thousandths(ball.visibility)}});
  }
  return out;
}

}  // namespace sslv
