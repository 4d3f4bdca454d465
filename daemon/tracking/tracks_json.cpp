// SPDX-License-Identifier: Apache-2.0
#include "tracking/tracks_json.h"

#include <cmath>

namespace sslv {
namespace {

/// Viewers do not need more digits, and fewer digits need less bandwidth on bad Wi-Fi.
double to_tenths(double value) {
  return std::round(value * 10) / 10;
}
double to_thousandths(double value) {
  return std::round(value * 1000) / 1000;
}

Json to_json(const TrackedRobot& robot) {
  return {{"team", name_of(robot.name.team)},
          {"id", robot.name.id},
          {"x", to_tenths(robot.place_mm.x())},
          {"y", to_tenths(robot.place_mm.y())},
          {"vx", to_tenths(robot.velocity_mm_s.x())},
          {"vy", to_tenths(robot.velocity_mm_s.y())},
          {"orientation", to_thousandths(robot.orientation_rad)},
          {"turn_rad_s", to_thousandths(robot.turn_rad_s)},
          {"sigma_mm", to_tenths(robot.place_sigma_mm)},
          {"visibility", to_thousandths(robot.visibility)}};
}

Json to_json(const TrackedBall& ball) {
  return {{"x", to_tenths(ball.place_mm.x())},
          {"y", to_tenths(ball.place_mm.y())},
          {"z", to_tenths(ball.place_mm.z())},
          {"vx", to_tenths(ball.velocity_mm_s.x())},
          {"vy", to_tenths(ball.velocity_mm_s.y())},
          {"vz", to_tenths(ball.velocity_mm_s.z())},
          {"visibility", to_thousandths(ball.visibility)}};
}

}  // namespace

Json to_json(const TrackedKick& kick) {
  Json out{{"number", kick.number},
           {"time", kick.t_s},
           {"x", to_tenths(kick.place_mm.x())},
           {"y", to_tenths(kick.place_mm.y())},
           {"vx", to_tenths(kick.velocity_mm_s.x())},
           {"vy", to_tenths(kick.velocity_mm_s.y())},
           {"vz", to_tenths(kick.velocity_mm_s.z())},
           {"speed_m_s", to_thousandths(kick.velocity_mm_s.norm() * 1e-3)},
           {"is_chip", kick.is_chip},
           {"landing", nullptr},
           {"robot", nullptr}};
  if (kick.is_chip) out["landing"] = {to_tenths(kick.landing_mm.x()), to_tenths(kick.landing_mm.y())};
  if (kick.robot) out["robot"] = {{"team", name_of(kick.robot->team)}, {"id", kick.robot->id}};
  return out;
}

Json to_json(const TrackedField& tracked) {
  Json out{{"number", tracked.number},
           {"time", tracked.t_s},
           {"robots", Json::array()},
           {"balls", Json::array()},
           {"kick", tracked.kick ? to_json(*tracked.kick) : Json(nullptr)}};
  for (const TrackedRobot& robot : tracked.robots) out["robots"].push_back(to_json(robot));
  for (const TrackedBall& ball : tracked.balls) out["balls"].push_back(to_json(ball));
  return out;
}

}  // namespace sslv
