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

/// Evaluation of a published frame.
struct FrameCheck {
  int robots = 0;       // completely visible robots
  int missed = 0;       // of these
  int wrong = 0;        // published ids that do not exist
  double error_mm = 0;  // sum over the robots that were found

  FrameCheck& operator+=(const FrameCheck& other);
};

/// A simulated camera of the settings as the image of a GigE camera. The scene is static, so the truth does
/// not depend on when an image was drawn.
class GigeScene {
 public:
  /// `camera`: from the settings, with source "simulator" and a calibration.
  explicit GigeScene(const Json& camera);

  /// Settings of fake_gige_camera; tests may change it.
  Json served;

  FrameCheck check(const SSL_DetectionFrame& frame) const;

 private:
  SimulatedScene truth_;
  CameraModel model_;
};

/// Returns when the camera is ready.
std::unique_ptr<ChildProcess> start_gige_camera(const std::string& served_file,
                                                const std::string& address = "127.0.0.1");

}  // namespace sslv::test
