// SPDX-License-Identifier: Apache-2.0
#include "net/vision_message.h"

#include "geometry/limits.h"
#include "net/parse.h"
#include "pipeline/validate.h"
#include "ssl_vision_wrapper.pb.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sslv {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

constexpr double kUsualRobotHeightMm = 140;  // assumed if the packet does not contain the height

template <class Things>
bool are_somewhere(const Things& things) {
  return std::all_of(things.begin(), things.end(),
                     [](const auto& one) { return std::isfinite(one.x()) && std::isfinite(one.y()); });
}

bool is_id(std::uint32_t id) {
  return id <= static_cast<std::uint32_t>(limits::kMaxId);
}

/// False for NaN.
bool is_time(double t_s) {
  return std::abs(t_s) <= limits::kMaxTime_s;
}

bool is_valid(const SSL_DetectionFrame& frame) {
  return is_id(frame.camera_id()) && is_time(frame.t_capture()) && is_time(frame.t_sent()) &&
         are_somewhere(frame.balls()) && are_somewhere(frame.robots_yellow()) &&
         are_somewhere(frame.robots_blue());
}

bool is_valid(const SSL_GeometryFieldSize& field) {
  for (int i = 0; i < field.GetDescriptor()->field_count(); ++i) {
    const auto size = number_of(field, *field.GetDescriptor()->field(i));
    if (size && !(*size >= 0 && *size <= limits::kMaxPlaceMm)) return false;  // false for NaN too
  }
  return field.field_length() > 0 && field.field_width() > 0;
}

SSL_GeometryFieldSize sizes_of(SSL_GeometryFieldSize& field) {
  field.clear_field_lines();
  field.clear_field_arcs();
  field.DiscardUnknownFields();
  return std::move(field);
}

/// Returns the number of dropped robots. Each team has its own limit, so that one team's robots cannot
/// displace the other team's.
std::uint64_t add_sightings(const google::protobuf::RepeatedPtrField<SSL_DetectionRobot>& robots, Team team,
                            CameraSightings& out) {
  std::uint64_t left_out = 0;
  std::size_t added = 0;
  for (const SSL_DetectionRobot& robot : robots) {
    if (added == limits::kMaxRobots / 2 || !robot.has_robot_id() || !robot.has_orientation() ||
        !is_id(robot.robot_id())) {
      ++left_out;
      continue;
    }
    out.robots.push_back({team,
                          static_cast<int>(robot.robot_id()),
                          {robot.x(), robot.y()},
                          robot.orientation(),
                          robot.has_height() ? static_cast<double>(robot.height()) : kUsualRobotHeightMm,
                          Eigen::Matrix2d::Zero(),
                          0});
    ++added;
  }
  return left_out;
}

/// Assumes the greatest camera height, because the camera's position is not known yet. HeardCameras validates
/// again once the position is known.
VisionMessage::Detection detection_of(const SSL_DetectionFrame& frame) {
  VisionMessage::Detection out{{}, frame.t_sent()};
  CameraSightings& image = out.arrived.image;
  image.camera_mm.z() = limits::kMaxCameraMm;
  image.camera = static_cast<int>(frame.camera_id());
  image.frame_number = frame.frame_number();
  image.t_capture_s = frame.t_capture();
  image.is_of_other_computer = true;
  out.arrived.left_out = add_sightings(frame.robots_yellow(), Team::kYellow, image);
  out.arrived.left_out += add_sightings(frame.robots_blue(), Team::kBlue, image);
  for (const SSL_DetectionBall& ball : frame.balls())
    image.balls.push_back({{ball.x(), ball.y()}, Eigen::Matrix2d::Zero(), ball.confidence()});
  const InvalidCounts dropped = drop_invalid(image);
  out.arrived.left_out += dropped.robots + dropped.balls;
  return out;
}

}  // namespace

std::optional<double> number_of(const Message& message, const FieldDescriptor& field) {
  const auto* reflection = message.GetReflection();
  if (field.is_repeated() || !reflection->HasField(message, &field)) return std::nullopt;
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_INT32: return reflection->GetInt32(message, &field);
    case FieldDescriptor::CPPTYPE_FLOAT: return reflection->GetFloat(message, &field);
    case FieldDescriptor::CPPTYPE_DOUBLE: return reflection->GetDouble(message, &field);
    default: return std::nullopt;
  }
}

std::optional<VisionMessage> VisionMessage::read(std::span<const std::byte> datagram) {
  SSL_WrapperPacket packet;
  if (!parse(packet, datagram)) return std::nullopt;
  const bool says_other_things = !packet.GetReflection()->GetUnknownFields(packet).empty();
  if (!packet.has_detection() && !packet.has_geometry() && !says_other_things) return std::nullopt;
  VisionMessage out;
  if (packet.has_geometry()) {
    if (!is_valid(packet.geometry().field())) return std::nullopt;
    out.field = sizes_of(*packet.mutable_geometry()->mutable_field());
    for (const SSL_GeometryCameraCalibration& camera : packet.geometry().calib()) {
      const Eigen::Vector3d place_mm(camera.derived_camera_world_tx(), camera.derived_camera_world_ty(),
                                     camera.derived_camera_world_tz());
      if (out.cameras.size() < limits::kMaxCameras && is_id(camera.camera_id()) && is_camera_place(place_mm))
        out.cameras.push_back({static_cast<int>(camera.camera_id()), place_mm});
    }
  }
  if (packet.has_detection()) {
    if (!is_valid(packet.detection())) return std::nullopt;
    out.detection = detection_of(packet.detection());
  }
  return out;
}

}  // namespace sslv
