// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/simulator/simulator_options.h"
#include "config/config.h"
#include "lab/accuracy.h"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace sslv {

/// Time of the first image, and interval between images: so long that images have little in common.
inline constexpr double kFirstS = 1000, kStepS = 7.3;

/// A condition in one pixel format, with all names resolved.
struct Trial {
  Config config;  // with one camera
  SimulatorOptions source, learn_source;
  std::vector<int> halls;  // empty: the source's hall only
  AccuracyColors colors;
  std::optional<int> learn_frames;
  double px_per_mm;
  int frames;
  AccuracyLimits limits;
};

/// Throws SettingsError, beginning with the key in the suite.
Trial trial_of(const AccuracySuite& suite, std::size_t condition, const std::string& pixel_format);

}  // namespace sslv
