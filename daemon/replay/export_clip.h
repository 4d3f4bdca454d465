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
  kRaw,  // the camera's bytes, row by row; the upper 8 bits of larger samples
};

struct ExportOptions {
  std::filesystem::path folder;  // created; must be empty if it exists
  ExportFormat format = ExportFormat::kPng;
  std::optional<std::uint32_t> camera_id{};  // none: every camera of the clip
  ClipSpan span{};
  bool with_coco = false;
  /// Blackens everything except the ground up to 300 mm outside the field's lines, and robots on it.
  bool is_anonymous = false;
};

struct ExportedCamera {
  std::uint32_t camera_id = 0;
  std::uint64_t frames = 0, robots = 0, balls = 0;
  std::vector<std::string> doubts{};  // why detections may differ from the live ones
};

/// Writes a folder for each camera (camera_0 and so on) with these files:
/// - its frames by number, frame_000042.png or .raw;
/// - truth.jsonl, a line with the unchecked detections of each frame (as `ssl-visionlab score` and `annotate`
///   read it, with "t", the capture time in Unix s);
/// - frames.json (as `simulate` writes it);
/// - with_coco: coco.json (COCO's object detection: images, annotations, categories).
/// Throws ClipError, SettingsError and StorageError; StorageError also if is_anonymous is set and a frame's
/// camera is not calibrated.
std::vector<ExportedCamera> export_clip(ClipReader& clip, const ExportOptions& options);

/// "frame_000042": a frame's name in JSON lines and in the names of exported files.
std::string clip_frame_name(std::uint32_t number);

}  // namespace sslv
