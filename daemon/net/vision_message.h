// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ssl_vision_geometry.pb.h"
#include "tracking/sightings.h"

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace sslv {

/// A validated packet of another vision: all values are finite and within geometry/limits.h. Only read()
/// creates messages, so users need no further checks.
class VisionMessage {
 public:
  /// Empty for invalid bytes and for packets outside the limits. Unknown fields are ignored; a packet with
  /// only unknown fields is an empty message.
  static std::optional<VisionMessage> read(std::span<const std::byte> datagram);

  struct Camera {
    int id;
    Eigen::Vector3d place_mm;  // the camera's position
  };
  struct Detection {
    ArrivedSightings arrived;  // times by the other computer's clock (Unix s)
    double t_sent_s;
  };
  std::optional<SSL_GeometryFieldSize> field;  // sizes only, without lines and arcs
  std::vector<Camera> cameras;                 // calibrated cameras only
  std::optional<Detection> detection;

 private:
  VisionMessage() = default;
};

/// The value of a numeric field; empty for an absent or non-numeric field.
std::optional<double> number_of(const google::protobuf::Message& message,
                                const google::protobuf::FieldDescriptor& field);

}  // namespace sslv
