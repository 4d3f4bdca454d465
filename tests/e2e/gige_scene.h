// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "capture/simulator/simulator_scene.h"
#include "geometry/camera_model.h"
#include "ssl_vision_detection.pb.h"
#include "support/child_process.h"

#include <memory>
#include <string>

namespace sslv::test {

/// What is right in a published frame.
struct FrameCheck {
  int robots = 0;       // that are wholly in the picture
  int missed = 0;       // of these
  int wrong = 0;        // published ids that are not there
  double error_mm = 0;  // summed up over those that were found

  FrameCheck& operator+=(const FrameCheck& other);
};

/// A simulated camera of the settings as the picture of a GigE camera. What it sees stands still, so that the
/// truth does not depend on when a picture was drawn.
class GigeScene {
 public:
  /// `camera`: of the settings, with source "simulator" and calibration.
  explicit GigeScene(const Json& camera);

  /// For fake_gige_camera; tests may change it.
  Json served;

  FrameCheck check(const SSL_DetectionFrame& frame) const;

 private:
  SimulatedScene truth_;
  CameraModel model_;
};

/// Ready when it returns.
std::unique_ptr<ChildProcess> start_gige_camera(const std::string& served_file,
                                                const std::string& address = "127.0.0.1");

}  // namespace sslv::test
