// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "capture/source.h"

#include <string>

namespace sslv {

struct SimulateOptions {
  Json source = Json::object();  // the simulator's options, without "backend"
  SourceContext context;         // camera, field and robot heights
  int frames = 100;
  double start_s = 0;  // Unix time of the first frame
  std::string folder;  // created if it is missing
  bool raw = false;    // bytes in the camera's pixel format (.raw) instead of images in full colour (.ppm)
};

/// Writes frame_000000.ppm (or .raw) and so on, 1/frame_rate_hz apart (1/60 s without a rate), truth.jsonl
/// with one line a frame (SimulatedCamera::truth), and frames.json: {"pixel_format", "width", "height",
/// "camera", "frames": [{"file", "t"}]}. The same options give the same bytes. Throws SettingsError,
/// CaptureError, and std::system_error for a file that cannot be written.
void simulate(const SimulateOptions& options);

}  // namespace sslv
