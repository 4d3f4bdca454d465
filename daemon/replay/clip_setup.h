// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "clips/clip.h"
#include "config/config.h"
#include "pipeline/camera_pipeline.h"

#include <cstddef>
#include <memory>
#include <string>

namespace sslv {

/// The setup of `config.cameras[i]` for a clip. It always contains the colour table itself, even if the
/// settings load it from a file or a service, and only the stages that run.
ClipSetup clip_setup(const Config& config, std::size_t i, const CameraSetup& setup);

/// The inverse of clip_setup(), also for programs built without the camera's backend. `pipeline`: the
/// previous pipeline, reused with its stages' state if the stack is the same; null: there is none. Throws
/// SettingsError, beginning with `path`.
CameraSetup setup_of(const ClipSetup& clip, std::shared_ptr<Pipeline> pipeline, const std::string& path);

/// Replacements for parts of the live setup.
struct OtherSetup {
  /// Settings with a camera of the same id; null: the clip's settings. If the colour settings equal the
  /// clip's, the clip's colour table is used, as adapted to the light of that moment. With
  /// height_from_referee, a robot height that the game controller sent live is kept, too.
  std::shared_ptr<const Config> settings{};
  std::string path{};                  // name of the settings in messages
  std::shared_ptr<const Lut> table{};  // null: the settings' table
};

/// The setup for frames that were processed live with `clip`. Throws like setup_of(), and SettingsError for
/// settings without that camera; messages about `other` begin with its path.
CameraSetup setup_with(const OtherSetup& other, const ClipSetup& clip, std::shared_ptr<Pipeline> pipeline,
                       const std::string& path);

}  // namespace sslv
