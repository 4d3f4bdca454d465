// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "clips/clip.h"
#include "config/config.h"
#include "pipeline/camera_pipeline.h"

#include <cstddef>
#include <memory>

namespace sslv {

/// What the camera at place `i` of the list runs with, for a clip.
ClipSetup clip_setup(const Config& config, std::size_t i, const CameraSetup& setup);

/// The same the other way round, for any program. `pipeline`: the one before, which is kept with what its
/// stages remember when the stack is the same; null: none. Throws SettingsError, beginning with `path`.
CameraSetup setup_of(const ClipSetup& clip, std::shared_ptr<Pipeline> pipeline, const std::string& path);

}  // namespace sslv
