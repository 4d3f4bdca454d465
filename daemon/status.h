// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "config.h"
#include "net/multicast.h"
#include "net/other_visions.h"
#include "net/packets.h"
#include "net/referee_listener.h"
#include "running_camera.h"

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace sslv {

/// A camera and its health, read once, so that alerts and figures agree.
struct CameraNow {
  std::shared_ptr<RunningCamera> camera;
  CameraHealth health;
};

/// What the status is made of, at one moment.
struct StatusInput {
  double time_s = 0, started_s = 0;
  const Config& config;
  MulticastStatus network;
  std::shared_ptr<const Geometry> geometry;  // what is sent
  std::vector<OtherVision> other_visions;
  std::uint64_t refused_packets = 0;  // that came to the vision group
  std::string listening_error;        // why the vision group cannot be heard
  RefereeStatus referee;
  std::uint64_t settings_revision = 0;
  int viewers = 0;
  std::string settings_problem;
  std::vector<CameraNow> cameras;
};

/// The status object of docs/openapi.json.
Json status_json(const StatusInput& input);

/// One line: "2/2 cameras 60.0 fps p99 0.9 ms -> 224.5.23.2:10006".
std::string status_line(const StatusInput& input);

}  // namespace sslv
