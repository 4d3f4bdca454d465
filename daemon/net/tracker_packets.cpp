// SPDX-License-Identifier: Apache-2.0
#include "net/tracker_packets.h"

#include <cstdint>

namespace sslv {
namespace {

constexpr double kMetersPerMm = 1e-3;

float meters(double mm) {
  return static_cast<float>(mm * kMetersPerMm);
}

void write_place(const Eigen::Vector2d& mm, Vector2& out) {
  out.set_x(meters(mm.x()));
  out.set_y(meters(mm.y()));
}

void write_place(const Eigen::Vector3d& mm, Vector3& out) {
  out.set_x(meters(mm.x()));
  out.set_y(meters(mm.y()));
  out.set_z(meters(mm.z()));
}

void write_name(const RobotName& name, RobotId& out) {
  out.set_id(static_cast<std::uint32_t>(name.id));
  out.set_team(name.team == Team::kYellow ? ::YELLOW : ::BLUE);
}

bool is_under_way(const TrackedKick& kick, const TrackedField& tracked) {
  constexpr double kLongest_s = 10, kSlowest_mm_s = 50;
  return !tracked.balls.empty() && tracked.t_s - kick.t_s < kLongest_s &&
         tracked.balls.front().velocity_mm_s.norm() > kSlowest_mm_s;
}

}  // namespace

void write_tracked(const TrackedField& tracked, const TrackerSource& source, TrackerWrapperPacket& packet) {
  packet.set_uuid(source.uuid);
  packet.set_source_name(source.name);
  TrackedFrame& frame = *packet.mutable_tracked_frame();
  frame.set_frame_number(tracked.number);
  frame.set_timestamp(tracked.t_s);
  frame.clear_balls();
  for (const TrackedBall& ball : tracked.balls) {
    ::TrackedBall& out = *frame.add_balls();
    write_place(ball.place_mm, *out.mutable_pos());
    write_place(ball.velocity_mm_s, *out.mutable_vel());
    out.set_visibility(static_cast<float>(ball.visibility));
  }
  frame.clear_robots();
  for (const TrackedRobot& robot : tracked.robots) {
    ::TrackedRobot& out = *frame.add_robots();
    write_name(robot.name, *out.mutable_robot_id());
    write_place(robot.place_mm, *out.mutable_pos());
    out.set_orientation(static_cast<float>(robot.orientation_rad));
    write_place(robot.velocity_mm_s, *out.mutable_vel());
    out.set_vel_angular(static_cast<float>(robot.turn_rad_s));
    out.set_visibility(static_cast<float>(robot.visibility));
  }
  if (tracked.kick && is_under_way(*tracked.kick, tracked)) {
    const TrackedKick& kick = *tracked.kick;
    KickedBall& out = *frame.mutable_kicked_ball();
    write_place(kick.place_mm, *out.mutable_pos());
    write_place(kick.velocity_mm_s, *out.mutable_vel());
    out.set_start_timestamp(kick.t_s);
    out.set_stop_timestamp(kick.stop_s);
    write_place(kick.stop_mm, *out.mutable_stop_pos());
    if (kick.robot) {
      write_name(*kick.robot, *out.mutable_robot_id());
    } else {
      out.clear_robot_id();
    }
  } else {
    frame.clear_kicked_ball();
  }
  if (frame.capabilities_size() == 0) {
    for (const Capability one :
         {CAPABILITY_DETECT_FLYING_BALLS, CAPABILITY_DETECT_MULTIPLE_BALLS, CAPABILITY_DETECT_KICKED_BALLS})
      frame.add_capabilities(one);
  }
}

std::span<const std::byte> serialize(const TrackerWrapperPacket& packet, std::vector<std::byte>& buffer) {
  buffer.resize(packet.ByteSizeLong());
  packet.SerializeWithCachedSizesToArray(reinterpret_cast<std::uint8_t*>(buffer.data()));
  return buffer;
}

}  // namespace sslv
