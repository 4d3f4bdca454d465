// SPDX-License-Identifier: Apache-2.0
#include "net/packets.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sslv {
namespace {

float wire_confidence(double confidence) {
  return confidence > 0 ? static_cast<float>(std::min(confidence, 1.0)) : 0.0F;  // NaN is not > 0
}

float wire_orientation(double angle_rad) {
  // The float nearest to pi is larger than pi; use the next smaller one, so that receivers' range checks
  // pass.
  constexpr float kLargest = 3.1415925F;
  const double wrapped = std::remainder(angle_rad, 2 * std::numbers::pi);
  return wrapped <= -kLargest ? kLargest : std::min(static_cast<float>(wrapped), kLargest);
}

/// Moves the last message to its place by descending confidence. Costs nothing if the messages are already
/// sorted.
template <class Message>
void sink_last(google::protobuf::RepeatedPtrField<Message>& messages) {
  for (int i = messages.size() - 1; i > 0 && messages[i - 1].confidence() < messages[i].confidence(); --i) {
    messages.SwapElements(i - 1, i);
  }
}

void write_robot(const Robot& robot, SSL_DetectionRobot& out) {
  out.set_confidence(wire_confidence(robot.confidence));
  out.set_robot_id(static_cast<std::uint32_t>(robot.id));
  out.set_x(static_cast<float>(robot.x_mm));
  out.set_y(static_cast<float>(robot.y_mm));
  out.set_orientation(wire_orientation(robot.orientation_rad));
  out.set_pixel_x(static_cast<float>(robot.pixel_x));
  out.set_pixel_y(static_cast<float>(robot.pixel_y));
  out.set_height(static_cast<float>(robot.height_mm));
}

void write_ball(const Ball& ball, SSL_DetectionBall& out) {
  out.set_confidence(wire_confidence(ball.confidence));
  out.set_area(ball.area_px);
  out.set_x(static_cast<float>(ball.x_mm));
  out.set_y(static_cast<float>(ball.y_mm));
  out.set_pixel_x(static_cast<float>(ball.pixel_x));
  out.set_pixel_y(static_cast<float>(ball.pixel_y));
}

void write_point(double x, double y, Vector2f& out) {
  out.set_x(static_cast<float>(x));
  out.set_y(static_cast<float>(y));
}

SSL_FieldShapeType shape_type(const std::string& name) {
  SSL_FieldShapeType type = Undefined;
  SSL_FieldShapeType_Parse(name, &type);
  return type;
}

void write_field(const FieldSize& field, SSL_GeometryFieldSize& out) {
  out.set_field_length(field.field_length);
  out.set_field_width(field.field_width);
  out.set_goal_width(field.goal_width);
  out.set_goal_depth(field.goal_depth);
  out.set_boundary_width(field.boundary_width);
  for (const FieldLine& line : field_lines(field)) {
    SSL_FieldLineSegment& segment = *out.add_field_lines();
    segment.set_name(line.name);
    write_point(line.x1, line.y1, *segment.mutable_p1());
    write_point(line.x2, line.y2, *segment.mutable_p2());
    segment.set_thickness(static_cast<float>(line.thickness));
    segment.set_type(shape_type(line.name));
  }
  for (const FieldArc& arc : field_arcs(field)) {
    SSL_FieldCircularArc& segment = *out.add_field_arcs();
    segment.set_name(arc.name);
    write_point(arc.x, arc.y, *segment.mutable_center());
    segment.set_radius(static_cast<float>(arc.radius));
    segment.set_a1(static_cast<float>(arc.a1));
    segment.set_a2(static_cast<float>(arc.a2));
    segment.set_thickness(static_cast<float>(arc.thickness));
    segment.set_type(shape_type(arc.name));
  }
  out.set_penalty_area_depth(field.penalty_area_depth);
  out.set_penalty_area_width(field.penalty_area_width);
  out.set_center_circle_radius(field.center_circle_radius);
  out.set_line_thickness(field.line_thickness);
  out.set_goal_center_to_penalty_mark(field.goal_center_to_penalty_mark);
  out.set_goal_height(field.goal_height);
  out.set_ball_radius(static_cast<float>(field.ball_radius));
  out.set_max_robot_radius(static_cast<float>(field.max_robot_radius));
  out.set_boundary_width_goal_line(field.boundary_width_goal_line);
  if (field.goal_substitution_area_width > 0) {
    out.set_goal_substitution_area_width(field.goal_substitution_area_width);
  }
}

void write_camera(const CalibratedCamera& camera, SSL_GeometryCameraCalibration& out) {
  const CameraCalibration& c = camera.model.calibration();
  out.set_camera_id(camera.id);
  out.set_focal_length(static_cast<float>(c.focal_length));
  out.set_principal_point_x(static_cast<float>(c.principal_point_x));
  out.set_principal_point_y(static_cast<float>(c.principal_point_y));
  out.set_distortion(static_cast<float>(c.distortion));
  // Normalised, because some receivers assume a unit quaternion.
  const Eigen::Vector4d q = Eigen::Vector4d(c.q0, c.q1, c.q2, c.q3).normalized();
  out.set_q0(static_cast<float>(q[0]));
  out.set_q1(static_cast<float>(q[1]));
  out.set_q2(static_cast<float>(q[2]));
  out.set_q3(static_cast<float>(q[3]));
  out.set_tx(static_cast<float>(c.tx));
  out.set_ty(static_cast<float>(c.ty));
  out.set_tz(static_cast<float>(c.tz));
  // Always sent, because a widely used tracker ignores calibrations without these fields.
  const Eigen::Vector3d& position_mm = camera.model.position_mm();
  out.set_derived_camera_world_tx(static_cast<float>(position_mm.x()));
  out.set_derived_camera_world_ty(static_cast<float>(position_mm.y()));
  out.set_derived_camera_world_tz(static_cast<float>(position_mm.z()));
  if (c.pixel_image_width > 0 && c.pixel_image_height > 0) {
    out.set_pixel_image_width(static_cast<std::uint32_t>(c.pixel_image_width));
    out.set_pixel_image_height(static_cast<std::uint32_t>(c.pixel_image_height));
  }
}

void write_ball_models(const BallModels& models, SSL_GeometryModels& out) {
  SSL_BallModelStraightTwoPhase& straight = *out.mutable_straight_two_phase();
  straight.set_acc_slide(models.acc_slide);
  straight.set_acc_roll(models.acc_roll);
  straight.set_k_switch(models.k_switch);
  SSL_BallModelChipFixedLoss& chip = *out.mutable_chip_fixed_loss();
  chip.set_damping_xy_first_hop(models.damping_xy_first_hop);
  chip.set_damping_xy_other_hops(models.damping_xy_other_hops);
  chip.set_damping_z(models.damping_z);
}

}  // namespace

void write_detection(const FrameInfo& info, const RobotList& robots, const BallList& balls, double t_sent_s,
                     SSL_WrapperPacket& packet) {
  packet.Clear();
  packet.set_source(SSL_SOURCE_OTHER);
  SSL_DetectionFrame& frame = *packet.mutable_detection();
  frame.set_frame_number(info.number);
  frame.set_t_capture(info.times.t_capture_s);
  frame.set_t_sent(t_sent_s);
  frame.set_camera_id(info.camera_id);
  if (info.times.t_capture_camera_s) frame.set_t_capture_camera(*info.times.t_capture_camera_s);
  for (const Robot& robot : robots.robots) {
    auto& team = robot.team == Team::kYellow ? *frame.mutable_robots_yellow() : *frame.mutable_robots_blue();
    write_robot(robot, *team.Add());
    sink_last(team);
  }
  for (const Ball& ball : balls.balls) {
    write_ball(ball, *frame.add_balls());
    sink_last(*frame.mutable_balls());
  }
}

void write_geometry(const Geometry& geometry, SSL_WrapperPacket& packet) {
  packet.Clear();
  packet.set_source(SSL_SOURCE_OTHER);
  SSL_GeometryData& data = *packet.mutable_geometry();
  write_field(geometry.field, *data.mutable_field());
  for (const CalibratedCamera& camera : geometry.cameras) write_camera(camera, *data.add_calib());
  if (geometry.ball_models) write_ball_models(*geometry.ball_models, *data.mutable_models());
}

std::span<const std::byte> serialize(const SSL_WrapperPacket& packet, std::vector<std::byte>& buffer) {
  buffer.resize(packet.ByteSizeLong());
  packet.SerializeWithCachedSizesToArray(reinterpret_cast<std::uint8_t*>(buffer.data()));
  return buffer;
}

}  // namespace sslv
