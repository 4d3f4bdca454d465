// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "alerts.h"
#include "base/json.h"
#include "running_camera.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace sslv {

/// What the status is made of, at one moment.
struct StatusInput {
  double time_s = 0, uptime_s = 0;
  HealthInput health;
  std::vector<Alert> alerts;
  std::uint64_t refused_packets = 0;  // that came to the vision group
  std::uint64_t settings_revision = 0;
  int viewers = 0;
  std::vector<std::shared_ptr<RunningCamera>> cameras;  // those of `health`
};

/// The status object of docs/openapi.json.
Json status_json(const StatusInput& input);

/// One line: "2/2 cameras 60.0 fps p99 0.9 ms -> 224.5.23.2:10006".
std::string status_line(const HealthInput& input);

}  // namespace sslv
