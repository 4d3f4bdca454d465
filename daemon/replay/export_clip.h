// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "replay/replay_clip.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace sslv {

enum class ExportFormat : std::uint8_t {
  kPng,  // RGB
  kRaw,  // the camera's bytes, row after row; of more than 8 bits a sample the upper ones
};

struct ExportOptions {
  std::filesystem::path folder;  // made; must be empty if it is there
  ExportFormat format = ExportFormat::kPng;
  std::optional<std::uint32_t> camera_id{};  // none: every camera of the clip
  ClipSpan span{};
  bool with_coco = false;
  /// Everything is black that shows neither ground up to 300 mm outside the field's lines nor robots that
  /// stand there.
  bool is_anonymous = false;
};

/// What was written for one camera.
struct ExportedCamera {
  std::uint32_t camera_id = 0;
  std::uint64_t frames = 0, robots = 0, balls = 0;
  std::vector<std::string> doubts{};  // why what was found may not be what was found live
};

/// Writes a folder for each camera, camera_0 and so on: its frames, frame_000042.png or .raw by their
/// numbers; truth.jsonl, a line of what was found in each frame, which nobody has checked yet (as
/// `ssl-visionctl score` and `annotate` read it, with "t", the capture time in Unix s); frames.json (as
/// `simulate` writes it); and coco.json (COCO's object detection: images, annotations, categories). Throws
/// ClipError, SettingsError, StorageError, the last also where a frame's camera is not calibrated and
/// is_anonymous is asked for.
std::vector<ExportedCamera> export_clip(ClipReader& clip, const ExportOptions& options);

/// "frame_000042": how exported frames are called, and lines about them.
std::string clip_frame_name(std::uint32_t number);

}  // namespace sslv
