// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "health/computer.h"
#include "net/multicast.h"
#include "running_camera.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace sslv {

/// What monitoring is told, at one moment.
struct MetricsInput {
  std::vector<std::shared_ptr<RunningCamera>> cameras;
  MulticastStatus network;
  std::optional<ClockFigures> clock;
  int viewers = 0;
  double settings_since_s = 0;  // Unix time when the newest settings came into force
};

/// All metrics in the text format of Prometheus; docs/operating.md lists them.
std::string metrics_text(const MetricsInput& input);

struct CameraNow {
  int id;
  CameraHealth health;
};

/// Why the watchdog is not fed: a camera's thread that neither goes on nor is known to open its camera. Empty
/// while all is well. `now_ns`: of the steady clock.
std::string find_hanging(const std::vector<CameraNow>& cameras, std::int64_t now_ns);

/// What is missing for all cameras' packets to leave, a line for each; empty when nothing is.
std::string find_missing(const std::vector<CameraNow>& cameras, const MulticastStatus& network);

}  // namespace sslv
