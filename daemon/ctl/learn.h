// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "colors/learn_colors.h"
#include "config/config.h"

#include <cstddef>
#include <iosfwd>
#include <string>

namespace sslv {

struct LearnInput {
  std::string path, pixel_format;
  int width = 0, height = 0;  // of raw frames
  int frames = 3;
  int every = 1;  // of so many images one is looked at
};

/// Learns a camera's colours from recorded images, with that camera's field, calibration, mask, teams and
/// patterns. What cannot be read of them goes to `problems`. Throws SettingsError, and CaptureError when no
/// image can be used.
LearntColors learn_from_recording(const Config& config, std::size_t camera_index, const LearnInput& input,
                                  std::ostream& problems);

/// For a terminal, of what learnt_colors_json() makes.
std::string learnt_colors_text(const Json& learnt);

}  // namespace sslv
