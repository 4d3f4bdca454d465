// SPDX-License-Identifier: Apache-2.0
#pragma once

// Results <-> the league's messages (proto/). Messages are filled afresh but keep their memory, so a message
// that is used again for every frame allocates nothing in steady state.

#include "base/params.h"
#include "geometry/camera_model.h"
#include "geometry/field.h"
#include "image/frame_info.h"
#include "ssl_vision_wrapper.pb.h"
#include "vision/detections.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <tuple>
#include <vector>

namespace sslv {

/// How the ball slows down, for the teams' predictions; the defaults are those of RoboCup 2026. One flat
/// struct for SSL_BallModelStraightTwoPhase and SSL_BallModelChipFixedLoss.
struct BallModels {
  double acc_slide = -3.40;
  double acc_roll = -0.45;
  double k_switch = 0.64;
  double damping_xy_first_hop = 0.55;
  double damping_xy_other_hops = 0.88;
  double damping_z = 0.54;

  static constexpr auto fields() {
    using B = BallModels;
    return std::tuple{
        number("acc_slide", &B::acc_slide, -100.0, 0.0, "m/s2", "acceleration of a sliding ball"),
        number("acc_roll", &B::acc_roll, -100.0, 0.0, "m/s2", "acceleration of a rolling ball"),
        number("k_switch", &B::k_switch, 0.0, 1.0, "",
               "fraction of the kick's speed at which the ball starts to roll"),
        number("damping_xy_first_hop", &B::damping_xy_first_hop, 0.0, 1.0, "",
               "speed kept along the floor, first hop"),
        number("damping_xy_other_hops", &B::damping_xy_other_hops, 0.0, 1.0, "",
               "speed kept along the floor, later hops"),
        number("damping_z", &B::damping_z, 0.0, 1.0, "", "upward speed kept at each hop"),
    };
  }
};

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

/// Makes `packet` the geometry packet. Lines have the places the field's sizes say.
void write_geometry(const Geometry& geometry, SSL_WrapperPacket& packet);

/// The packet's bytes; they lie in `buffer`, whose capacity is kept.
std::span<const std::byte> serialize(const SSL_WrapperPacket& packet, std::vector<std::byte>& buffer);

}  // namespace sslv
