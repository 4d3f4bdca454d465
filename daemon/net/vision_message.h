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

/// A validated packet of another vision: everything is finite and within geometry/limits.h. Only read() makes
/// one, so code that takes a VisionMessage checks nothing again.
class VisionMessage {
 public:
  /// Nothing for bytes that are no packet and for packets outside the limits. Unknown fields are ignored; a
  /// packet with nothing else is an empty message.
  static std::optional<VisionMessage> read(std::span<const std::byte> datagram);

  struct Camera {
    int id;
    Eigen::Vector3d place_mm;  // where it hangs
  };
  struct Detection {
    ArrivedSightings arrived;  // with times of the other computer's clock (Unix s)
    double t_sent_s;
  };
  std::optional<SSL_GeometryFieldSize> field;  // sizes alone, without lines and arcs
  std::vector<Camera> cameras;                 // those that are calibrated
  std::optional<Detection> detection;

 private:
  VisionMessage() = default;
};

/// A number that is set in a message; nothing for an absent field or one of another kind.
std::optional<double> number_of(const google::protobuf::Message& message,
                                const google::protobuf::FieldDescriptor& field);

}  // namespace sslv
