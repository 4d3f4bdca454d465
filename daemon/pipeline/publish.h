// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipeline/camera_stage.h"

#include <tuple>

namespace sslv {

/// Passes the frame's detections to the sink on the camera's own thread, so that nothing delays them between
/// the last detector and the socket.
class Publish {
 public:
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, const FrameInfo& info, const Scene& scene, const RobotList& robots,
               const BallList& balls, DetectionSink& sink) noexcept {
    sink.publish(info, scene, robots, balls);
  }
};

}  // namespace sslv
