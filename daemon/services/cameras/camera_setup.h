// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.h"
#include "pipeline/camera_pipeline.h"

#include <array>
#include <cstddef>
#include <memory>
#include <optional>

namespace sslv {

/// A running camera's settings and setup.
struct CameraInUse {
  const Config& config;  // contains the camera's settings
  const CameraSettings& settings;
  const CameraSetup& setup;
};

/// Setup of a camera after a change of settings.
struct NewSetup {
  CameraSetup setup;          // without a pipeline if the stages still have to be made
  bool keeps_colors = false;  // when applied, keep the previous setup's colour tables

  /// Creates the stages and their parameters, unless the previous stages are kept.
  void make_stages(const CameraSettings& camera);
};

/// Plans the setup of the camera at index `i` of the list; `previous`: its current setup, if it is running.
/// Returns nothing if the processing of its frames does not change. Keeps the previous pipeline, with its
/// stages' state, if the stack is unchanged, and the colour tables if the colours are unchanged. Reads the
/// files named in the settings, but changes nothing. Throws SettingsError.
std::optional<NewSetup> plan_setup(const Config& config, std::size_t i,
                                   const std::optional<CameraInUse>& previous, const LoadTable& load_table);

/// Returns the same setup with these robot heights.
CameraSetup with_robot_heights(CameraSetup setup, const std::array<double, 2>& robot_height_mm);

}  // namespace sslv
