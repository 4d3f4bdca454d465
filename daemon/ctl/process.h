// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.h"
#include "pipeline/frame.h"

#include <functional>
#include <iosfwd>
#include <string>

namespace sslv {

struct ProcessOptions {
  std::string input;          // image, raw frame, video, or a folder of images or raw frames
  std::string pixel_format;   // of raw frames; empty: not raw
  int width = 0, height = 0;  // of raw frames
};

/// Runs the camera's stack over recorded input in one thread, without a daemon: the same frames give the same
/// detections. Frames of a clip or video have their own times, others are as far apart as frame_rate_hz of
/// the camera's source says, or 4 ms. Hands each frame to `use`, with its name. Frames that cannot be read
/// are named on `problems` and skipped. Returns how many were. Throws SettingsError and CaptureError.
int process_recording(const Config& config, std::size_t camera_index, const ProcessOptions& options,
                      const std::function<void(const std::string& name, const Frame&)>& use,
                      std::ostream& problems);

/// The same, writing one JSON object a line for each frame.
int process_recording(const Config& config, std::size_t camera_index, const ProcessOptions& options,
                      std::ostream& out, std::ostream& problems);

}  // namespace sslv
