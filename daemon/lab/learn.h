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
  int width = 0, height = 0;  // size of raw frames
  int frames = 3;
  int every = 1;  // only every n-th image is used
};

/// Learns a camera's colours from recorded images, with that camera's field, calibration, mask, teams and
/// patterns. Images that cannot be read are listed on `problems`. Throws SettingsError, and CaptureError if
/// no image can be used.
LearntColors learn_from_recording(const Config& config, std::size_t camera_index, const LearnInput& input,
                                  std::ostream& problems);

/// Text for a terminal from the result of learnt_colors_json().
std::string learnt_colors_text(const Json& learnt);

}  // namespace sslv
