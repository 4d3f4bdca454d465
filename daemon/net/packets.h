// SPDX-License-Identifier: Apache-2.0
#pragma once

// Writes results into the league's messages (proto/). Reusing a message keeps its memory, so that writing a
// frame allocates nothing in steady state.

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

/// The contents of a geometry packet.
struct Geometry {
  FieldSize field;
  std::vector<CalibratedCamera> cameras;    // calibrated cameras only
  std::optional<BallModels> ball_models{};  // empty: not published
};

/// Fills `packet` with the detection packet of one frame; `t_sent_s` in Unix seconds. Robots and balls are
/// sorted by descending confidence. Confidences are clamped to 0 .. 1 (NaN: 0), orientations wrapped to (-pi,
/// pi].
void write_detection(const FrameInfo& info, const RobotList& robots, const BallList& balls, double t_sent_s,
                     SSL_WrapperPacket& packet);

/// Fills `packet` with the geometry packet, including the lines from field_lines().
void write_geometry(const Geometry& geometry, SSL_WrapperPacket& packet);

/// The packet's bytes, stored in `buffer`, whose capacity is reused.
std::span<const std::byte> serialize(const SSL_WrapperPacket& packet, std::vector<std::byte>& buffer);

}  // namespace sslv
