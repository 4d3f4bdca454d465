// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipeline/camera_stage.h"

namespace sslv {

/// For tools that use the frames themselves: drops the publish stage's output.
struct NoSink : DetectionSink {
  void publish(const FrameInfo&, const Scene&, const RobotList&, const BallList&) noexcept override {}
};

}  // namespace sslv
