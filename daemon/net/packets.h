// SPDX-License-Identifier: Apache-2.0
#pragma once

// Results <-> the league's messages (proto/). Messages are filled again but keep their memory, so a message
// that is used again for every frame allocates nothing in steady state.

#include "geometry/ball_models.h"
#include "geometry/camera_model.h"
#include "geometry/field.h"
#include "image/frame_info.h"
#include "ssl_vision_wrapper.pb.h"
#include "vision/detections.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace sslv {

struct CalibratedCamera {
  std::uint32_t id;
  CameraModel model;
};

/// All that a geometry packet says.
struct Geometry {
  FieldSize field;
  std::vector<CalibratedCamera> cameras;    // those without a calibration are left out
  std::optional<BallModels> ball_models{};  // none: not published
};

/// Makes `packet` the detection packet of one frame; `t_sent_s` in Unix seconds. Robots and balls leave in
/// the order of falling confidence, whatever their order here; a confidence is held to 0 .. 1 (NaN: 0), an
/// orientation to (-pi, pi].
void write_detection(const FrameInfo& info, const RobotList& robots, const BallList& balls, double t_sent_s,
                     SSL_WrapperPacket& packet);

/// Makes `packet` the geometry packet. Its lines come from field_lines().
void write_geometry(const Geometry& geometry, SSL_WrapperPacket& packet);

/// The packet's bytes; they lie in `buffer`, whose capacity is kept.
std::span<const std::byte> serialize(const SSL_WrapperPacket& packet, std::vector<std::byte>& buffer);

}  // namespace sslv
