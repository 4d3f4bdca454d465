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
  std::string pixel_format;   // pixel format of raw frames; empty: the input is not raw
  int width = 0, height = 0;  // size of raw frames
};

/// Runs the camera's stack over recorded input in one thread, without a daemon: the same frames give the same
/// detections. Frames of a clip or video have their own times; other frames follow each other at the
/// frame_rate_hz of the camera's source, or every 4 ms. Passes each frame to `use`, with its name. Frames
/// that cannot be read are listed on `problems` and skipped. Returns the number of skipped frames. Throws
/// SettingsError and CaptureError.
int process_recording(const Config& config, std::size_t camera_index, const ProcessOptions& options,
                      const std::function<void(const std::string& name, const Frame&)>& use,
                      std::ostream& problems);

/// The same, writing one JSON object per line for each frame.
int process_recording(const Config& config, std::size_t camera_index, const ProcessOptions& options,
                      std::ostream& out, std::ostream& problems);

}  // namespace sslv
