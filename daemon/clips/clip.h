// SPDX-License-Identifier: Apache-2.0
#pragma once

// The contents of a clip: raw frames of one or more cameras, everything needed to process them again, and the
// packets that were sent. docs/recording.md describes the file format.

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

/// The file or memory is not a clip, or is damaged. The message is one line; for a file, the message begins
/// with the path.
struct ClipError : std::runtime_error {
  using runtime_error::runtime_error;
};

/// One camera's settings and colour table, valid for its frames until the next change.
struct ClipSetup {
  int camera_id = 0;
  /// "settings": the complete tree, with this camera only; "robot_height_mm": heights of the yellow and the
  /// blue robots; "patterns": the text of the patterns_file, or null.
  Json about = Json::object();
  /// The colour table as adapted to the light at that time, as a .lut file; empty: the table of the settings.
  std::vector<std::byte> table{};
};

/// One frame. Image, packet and memory are views of bytes that the frame does not own.
struct ClipFrame {
  FrameInfo info{};         // arrived_ns is 0 in a frame read from a clip
  std::uint32_t setup = 0;  // index in the clip's list of setups
  ImageView image{};        // empty: no image
  /// The SSL_WrapperPacket that was sent; empty if no packet was sent.
  std::span<const std::byte> packet{};
  /// The stages' state before this frame (Pipeline::save()); empty if it was not stored.
  std::span<const std::byte> memory{};
};

/// An event during the clip, or the reason why the clip was kept.
struct ClipEvent {
  double time_s = 0;   // Unix time
  std::string kind{};  // "alert", "goal", "command", "kept"...
  std::string text{};  // human-readable
};

/// Values of ClipAbout::kind for clips that a user requested and for crash clips.
inline constexpr std::string_view kKeptClip = "kept", kCrashClip = "crash";

/// A clip's metadata.
struct ClipAbout {
  std::string site{};             // name of the field
  std::string version{};          // version of the service that wrote the clip
  std::string kind{};             // cause of the clip: "kept", "alert", "goal", "command", "crash"
  std::string why{};              // human-readable cause: "kept by hand", an alert's title
  double begin_s = 0, end_s = 0;  // requested Unix times; frames may be missing at either end
};

}  // namespace sslv
