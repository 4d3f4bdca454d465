// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/clock.h"
#include "base/handover.h"
#include "clips/image_ring.h"
#include "config/config.h"
#include "net/vision_sender.h"
#include "pipeline/camera_pipeline.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

namespace sslv {

/// Selects the frames of a camera that are kept in memory.
struct RecordedFrames {
  std::shared_ptr<ImageRing> ring;  // null: nothing is kept
  int every_nth = 1;
};

/// Records the camera's last seconds: after each frame, the camera's thread copies it to a ring buffer. The
/// thread never waits and allocates nothing here.
class RecordedCamera final : public FrameObserver {
 public:
  using Clock = std::function<std::int64_t()>;  // steady, ns

  /// `sender`: sends the camera's packets; must outlive the camera's thread.
  RecordedCamera(int id, const DetectionSender& sender, Clock now_ns = steady_ns);

  // FrameObserver
  void frame_begins(const CameraSetup& setup) noexcept override;
  void frame_ends(const Frame& frame, const CameraSetup& setup) noexcept override;

  // For all threads other than the camera's.

  /// Takes effect with the next frame. Also copies the setups to the ring.
  void keep(RecordedFrames frames);
  /// Releases earlier rings that the camera's thread no longer uses.
  void tidy() const { frames_.load(); }
  /// Count and bytes of all images since the start, in the camera's format, kept or not.
  struct Seen {
    std::uint64_t frames = 0, bytes = 0;
  };
  Seen seen() const;

  /// Records a setup before the camera uses it, and assigns its number. `config`: the settings that the setup
  /// belongs to; null: the settings of the previous setup.
  void note(CameraSetup& setup, std::shared_ptr<const Config> config);
  /// Drops the setups before `number`, which no frame needs any more; keeps the newest setup.
  void forget_before(std::uint32_t number);

 private:
  struct Setup {
    std::shared_ptr<const CameraSetup> setup;
    std::shared_ptr<const Config> config;
  };
  void put_into_ring(const Setup& setup);

  const int id_;
  const DetectionSender& sender_;
  const Clock now_ns_;
  Handover<RecordedFrames> frames_{RecordedFrames{}};
  std::atomic<std::uint64_t> frames_seen_{0}, bytes_seen_{0};

  // Used by the camera's thread.
  std::vector<std::byte> memory_;  // saved state of the stages before this frame
  std::size_t memory_bytes_ = 0;   // bytes used in memory_; 0: this frame is not a keyframe
  std::int64_t next_key_ns_ = 0;   // time of the next keyframe
  ImageRing* ring_ = nullptr;      // ring used for the last frame
  const Pipeline* pipeline_ = nullptr;
  std::uint64_t count_ = 0;
  bool is_kept_ = false;  // whether this frame is kept

  mutable std::mutex mutex_;  // guards the members below
  std::vector<Setup> setups_;
  std::uint32_t next_number_ = 0;
  std::shared_ptr<ImageRing> ring_of_setups_;
};

}  // namespace sslv
