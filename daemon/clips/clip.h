// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a clip holds: raw frames of one or more cameras with all that they were processed with, and what was
// found and sent. docs/recording.md describes the file.

#include "base/json.h"
#include "image/frame_info.h"
#include "image/image.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace sslv {

/// A file or memory that is no clip, or a damaged one: one line; of a file it begins with the path.
struct ClipError : std::runtime_error {
  using runtime_error::runtime_error;
};

/// What a camera's frames were processed with, from one frame to the next change.
struct ClipSetup {
  int camera_id = 0;
  /// "settings": the complete tree with this camera alone; "robot_height_mm": of yellow and blue; "patterns":
  /// the text of the patterns_file, or null.
  Json about = Json::object();
  /// The colour table in the light of that moment, as a .lut file; empty: that of the settings.
  std::vector<std::byte> table{};
};

/// One frame, as it lies in memory that somebody else owns.
struct ClipFrame {
  FrameInfo info{};         // arrived_ns is 0 when it was read from a clip
  std::uint32_t setup = 0;  // place in the clip's list of setups
  ImageView image{};        // empty: it has none
  /// The packet that was sent, SSL_WrapperPacket; empty: none was.
  std::span<const std::byte> packet{};
  /// What the stages remembered before this frame (Pipeline::save()); empty: it was not kept.
  std::span<const std::byte> memory{};
};

/// Something that happened while the clip lasted, or why it was kept.
struct ClipEvent {
  double time_s = 0;   // Unix
  std::string kind{};  // "alert", "goal", "command", "kept"...
  std::string text{};  // for people
};

/// ClipAbout::kind of clips that somebody asked for, and of those that a crash left.
inline constexpr std::string_view kKeptClip = "kept", kCrashClip = "crash";

/// What a clip says about itself.
struct ClipAbout {
  std::string site{};             // name of the field
  std::string version{};          // of the service that wrote it
  std::string kind{};             // what it was made for: "kept", "alert", "goal", "command", "crash"
  std::string why{};              // for people: "kept by hand", an alert's title
  double begin_s = 0, end_s = 0;  // Unix time that was asked for; frames may lack at either end
};

}  // namespace sslv
