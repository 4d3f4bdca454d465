// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "capture/driver_calls.h"
#include "geometry/scene.h"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace sslv {

/// Opens cameras that are not in the settings, each for one image: on a separate thread with a timeout, one
/// at a time for each backend. A driver that hangs blocks only its own backend's cameras. Thread-safe.
class SourceImages {
 public:
  SourceImages();

  /// Returns a JPEG of a complete "source", at most `width_px` wide. Throws CaptureError with one line for
  /// the admin.
  std::vector<std::uint8_t> take(const Json& source, const Scene& scene, int width_px) const;

  /// Makes all calls that wait for images fail.
  void ask_to_stop() {
    for (const auto& [backend, calls] : calls_) calls.ask_to_stop();
  }

 private:
  std::map<std::string, DriverCalls> calls_;  // by backend
};

}  // namespace sslv
