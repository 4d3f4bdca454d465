// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.h"
#include "pipeline/camera_pipeline.h"

#include <array>
#include <cstddef>
#include <memory>
#include <optional>

namespace sslv {

/// A camera as it runs now.
struct CameraInUse {
  const Config& config;  // its settings are among them
  const CameraSettings& settings;
  const CameraSetup& setup;
};

/// What a camera's frames are processed with from a change of settings on.
struct NewSetup {
  CameraSetup setup;          // without stages as long as these are to be made
  bool keeps_colors = false;  // it keeps the tables that the setup before has at that moment

  /// Unless those of before go on: starts what they need.
  void make_stages(const CameraSettings& camera);
};

/// For the camera at place `i` of the list; `previous`: when it runs already. Nothing when nothing that its
/// frames are processed with has changed. The pipeline before, with what its stages remember, is kept when
/// the stack is the same, and its colour tables when the colours are. Reads the files that the settings name,
/// and has no effect. Throws SettingsError.
std::optional<NewSetup> plan_setup(const Config& config, std::size_t i,
                                   const std::optional<CameraInUse>& previous, const LoadTable& load_table);

/// The same setup with robots of these heights.
CameraSetup with_robot_heights(CameraSetup setup, const std::array<double, 2>& robot_height_mm);

}  // namespace sslv
