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

/// Opens cameras that the settings do not have, each for one image: in a thread of its own that is waited for
/// only so long, one at a time of each backend. A driver that hangs keeps only its own backend's cameras
/// away. May be used from any thread.
class SourceImages {
 public:
  SourceImages();

  /// A JPEG of what a complete "source" shows, at most `width_px` wide. Throws CaptureError with one line for
  /// the admin.
  std::vector<std::uint8_t> take(const Json& source, const Scene& scene, int width_px) const;

  /// Nobody waits for an image any more.
  void ask_to_stop() {
    for (const auto& [backend, calls] : calls_) calls.ask_to_stop();
  }

 private:
  std::map<std::string, DriverCalls> calls_;  // by backend
};

}  // namespace sslv
