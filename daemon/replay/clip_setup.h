// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "clips/clip.h"
#include "config/config.h"
#include "pipeline/camera_pipeline.h"

#include <cstddef>
#include <memory>
#include <string>

namespace sslv {

/// What the camera at place `i` of the list runs with, for a clip. The colour table is always there, whatever
/// file or service the settings have it from; of stages, those that run.
ClipSetup clip_setup(const Config& config, std::size_t i, const CameraSetup& setup);

/// The same the other way round, for any program. `pipeline`: the one before, which is kept with what its
/// stages remember when the stack is the same; null: none. Throws SettingsError, beginning with `path`.
CameraSetup setup_of(const ClipSetup& clip, std::shared_ptr<Pipeline> pipeline, const std::string& path);

/// What frames are processed with instead of what they were processed with live.
struct OtherSetup {
  /// Settings with a camera of the same id; null: those of the clip. Where their colours are the clip's,
  /// the table is the clip's too, in the light of that moment; likewise for a team whose height the game
  /// controller told.
  std::shared_ptr<const Config> settings{};
  std::string path{};                  // what messages call them
  std::shared_ptr<const Lut> table{};  // null: that of the settings
};

/// Those for frames that had the setup `clip` live. Throws as setup_of() does, and for settings without such
/// a camera; what is wrong with `other` begins with its path.
CameraSetup setup_with(const OtherSetup& other, const ClipSetup& clip, std::shared_ptr<Pipeline> pipeline,
                       const std::string& path);

}  // namespace sslv
