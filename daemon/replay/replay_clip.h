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

/// A time span of a clip, in s since its first frame.
struct ClipSpan {
  double from_s = 0;
  std::optional<double> to_s{};  // none: to its end
};

/// Processes one camera's frames of a clip again, with the live setup or another one, in the calling thread
/// and as fast as possible. Starts with the last live state of the stages before the span, else at the clip's
/// beginning, and also processes the frames from there to the span.
class ClipReplay {
 public:
  struct Result {
    std::size_t place = 0;                // index in ClipReader::entries()
    const ClipFrame* recorded = nullptr;  // the live image, packet and setup
    const Frame* frame = nullptr;         // with the new detections
    /// The packet as it would be sent, with the live packet's t_sent; empty: no stage publishes.
    std::span<const std::byte> packet{};
    /// Whether the frame is reproducible: the stages had their live state, the image is complete, and the
    /// settings are the clip's own. `packet` then equals the live packet byte for byte.
    bool is_exact = false;
  };

  /// `clip` must outlive this, and must not be used for other reads meanwhile. Without `other`, uses the
  /// clip's own settings. Throws ClipError for a clip without this camera.
  ClipReplay(ClipReader& clip, std::uint32_t camera_id, const ClipSpan& span = {},
             std::optional<OtherSetup> other = {});
  ~ClipReplay();
  ClipReplay(const ClipReplay&) = delete;
  ClipReplay& operator=(const ClipReplay&) = delete;

  /// Processes the next frame of the span; false after the last one. `result` is valid until the next call.
  /// Throws ClipError and SettingsError.
  bool next(Result& result);

  /// Reasons, besides `other`, why frames so far may differ from the live run: each kind once, with its first
  /// frame.
  const std::vector<std::string>& doubts() const { return doubts_; }
  /// Frames processed, also those before the span.
  std::uint64_t processed() const { return processed_; }
  /// The setup of the newest frame.
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
  double from_s_, to_s_;  // Unix time
  std::size_t next_ = 0;  // index in camera_.frames
  std::optional<std::uint32_t> setup_index_, last_number_;
  CameraSetup setup_;
  std::unique_ptr<Sink> sink_;
  std::unique_ptr<CameraPipeline> pipeline_;
  bool memory_is_live_ = false;  // the stages have their live state
  std::uint64_t processed_ = 0;
  std::vector<std::string> doubts_;
  std::vector<const char*> kinds_;  // kind of each entry of doubts_
};

}  // namespace sslv
