// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "e2e/frame_numbers.h"
#include "e2e/gige_scene.h"
#include "e2e/running_daemon.h"

#include <cstdio>
#include <memory>
#include <optional>
#include <string>

namespace sslv::test {

/// Camera 0 of the demo as a GigE camera with a larger Bayer sensor. A low frame rate, so that a busy
/// computer receives complete images.
class Gige : public DaemonTest {
 protected:
  static constexpr int kWidth = 1280, kHeight = 952;

  Gige() {
    Json& camera = settings_["cameras"][0];
    camera["calibration"].update(Json{{"focal_length", 758.15},
                                      {"principal_point_x", 642.0},
                                      {"principal_point_y", 472.8},
                                      {"pixel_image_width", kWidth},
                                      {"pixel_image_height", kHeight}});
    camera["source"].update(
        Json{{"width", kWidth}, {"height", kHeight}, {"pixel_format", "bayer_rg8"}, {"frame_rate_hz", 10}});
    scene_.emplace(camera);
    // On a busy computer heartbeats and images are late; the camera must not count as lost because of that.
    scene_->served["heartbeat_s"] = kPatience.count();
    camera["source"] = {{"backend", "aravis"}, {"camera", "127.0.0.1"}, {"silence_s", kPatience.count()}};
    settings_["cameras"][1]["source"]["frame_rate_hz"] = 20;
  }

  /// Starts the camera with the current scene_->served.
  std::unique_ptr<ChildProcess> start_camera() const {
    return start_gige_camera(folder_.write("served.json", scene_->served.dump(2)));
  }
  /// The next frame of a camera.
  SSL_DetectionFrame next_frame(std::uint32_t camera) {
    for (;;) {
      const SSL_WrapperPacket packet = receive(listener_);
      if (packet.has_detection() && packet.detection().camera_id() == camera) return packet.detection();
    }
  }

  std::optional<GigeScene> scene_;
};

/// A control as reported by the camera; null if it has none of this name.
inline Json control(const RunningDaemon& daemon, const std::string& name) {
  const Json answer = daemon.get("/api/cameras/0/controls");
  for (const Json& one : answer["controls"]) {
    if (one["name"] == name) return one;
  }
  return nullptr;
}

inline double exposure_us(const RunningDaemon& daemon) {
  return control(daemon, "ExposureTimeAbs")["value"].get<double>();
}

/// Checks that no frame of the watched camera 1 is missing.
inline void expect_nothing_missing(FrameNumbers& other) {
  other.stop();
  std::printf("other camera: %d frames, the longest gap %.1f ms\n", other.frames(),
              other.longest_gap_s() * 1e3);
  EXPECT_LE(other.missing(), other.overflows());
}

inline auto state_is(const char* state) {
  return [state](const Json& status) { return status["cameras"][0]["state"] == state; };
}

}  // namespace sslv::test
