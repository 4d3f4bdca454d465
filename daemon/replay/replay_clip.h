// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "clips/clip_reader.h"
#include "net/packets.h"
#include "pipeline/camera_pipeline.h"
#include "replay/clip_setup.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sslv {

/// Which frames of a clip, in s since its first one.
struct ClipSpan {
  double from_s = 0;
  std::optional<double> to_s{};  // none: to its end
};

/// One camera's frames of a clip through the stack once more: as the live run did, or with other settings. In
/// this thread, as fast as it goes. Stages begin with what they remembered live, where the clip has it; so
/// frames before the span are processed from there on, too.
class ClipReplay {
 public:
  struct Result {
    std::size_t place = 0;                // in ClipReader::entries()
    const ClipFrame* recorded = nullptr;  // its image, packet and setup
    const Frame* frame = nullptr;         // what was found now
    /// As it would be sent, with the time at which the live one was; empty: no stage publishes.
    std::span<const std::byte> packet{};
    /// The stages remembered what they did live, and the image is the whole one: with the clip's own settings
    /// the packet is the live one, byte for byte.
    bool is_exact = false;
  };

  /// `clip` must outlive this, and nobody else reads it meanwhile. `other`: none: the clip's own settings.
  /// Throws ClipError for a clip without this camera.
  ClipReplay(ClipReader& clip, std::uint32_t camera_id, const ClipSpan& span = {},
             std::optional<OtherSetup> other = {});
  ~ClipReplay();
  ClipReplay(const ClipReplay&) = delete;
  ClipReplay& operator=(const ClipReplay&) = delete;

  /// The next frame of the span, false behind the last one. All in `result` is valid until the next call.
  /// Throws ClipError and SettingsError.
  bool next(Result& result);

  /// Why frames so far were not exact, each reason once, with the first frame it holds for; empty: all were.
  const std::vector<std::string>& doubts() const { return doubts_; }
  /// Frames processed, also those before the span.
  std::uint64_t processed() const { return processed_; }
  /// Of the newest frame.
  const CameraSetup& setup() const { return setup_; }

 private:
  struct Sink;
  void use_setup(std::uint32_t setup);
  void follow_memory(const ClipFrame& recorded);
  void doubt(const char* kind, const std::string& text);

  ClipReader& clip_;
  const ClipReader::Camera& camera_;
  const std::uint32_t camera_id_;
  std::optional<OtherSetup> other_;
  double from_s_, to_s_;  // Unix
  std::size_t next_ = 0;  // in camera_.frames
  std::optional<std::uint32_t> setup_index_, last_number_;
  CameraSetup setup_;
  std::unique_ptr<Sink> sink_;
  std::unique_ptr<CameraPipeline> pipeline_;
  bool memory_is_live_ = false;  // the stages remember what they did live
  std::uint64_t processed_ = 0;
  std::vector<std::string> doubts_;
  std::vector<const char*> kinds_;  // of doubts_
};

}  // namespace sslv
