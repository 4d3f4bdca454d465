// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipeline/camera_stage.h"

namespace sslv {

/// For tools that look at the frames themselves: what the publish stage hands out goes nowhere.
struct NoSink : DetectionSink {
  void publish(const FrameInfo&, const Scene&, const RobotList&, const BallList&) noexcept override {}
};

}  // namespace sslv
