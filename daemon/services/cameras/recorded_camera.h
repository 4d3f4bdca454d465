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

/// What of a camera's frames is kept in memory.
struct RecordedFrames {
  std::shared_ptr<ImageRing> ring;  // null: nothing is kept
  int every_nth = 1;
};

/// The camera's last seconds: what its thread puts into memory after each frame. Its thread waits for nobody
/// and allocates nothing here.
class RecordedCamera final : public FrameObserver {
 public:
  using Clock = std::function<std::int64_t()>;  // steady, ns

  /// `sender`: what sends the camera's packets; must outlive the camera's thread.
  RecordedCamera(int id, const DetectionSender& sender, Clock now_ns = steady_ns);

  // FrameObserver
  void frame_begins(const CameraSetup& setup) noexcept override;
  void frame_ends(const Frame& frame, const CameraSetup& setup) noexcept override;

  // From any other thread.

  /// From the next frame on. Setups go into the ring as well.
  void keep(RecordedFrames frames);
  /// Lets go of memory that was kept before and that the camera's thread has left since.
  void tidy() const { frames_.load(); }
  /// Bytes of all images and their count since the start, as the camera gave them, kept or not.
  struct Seen {
    std::uint64_t frames = 0, bytes = 0;
  };
  Seen seen() const;

  /// A setup that the camera has from now on, before it gets it; `config`: that it is of; null: the same as
  /// the setup before. Gives it its number.
  void note(CameraSetup& setup, std::shared_ptr<const Config> config);
  /// Setups before it are not asked for any more.
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

  // The camera thread's.
  std::vector<std::byte> memory_;  // of the stages, before this frame
  std::size_t memory_bytes_ = 0;   // of it; 0: it is not kept with this frame
  std::int64_t next_key_ns_ = 0;   // when memory is kept again
  ImageRing* ring_ = nullptr;      // that the last frame went to
  const Pipeline* pipeline_ = nullptr;
  std::uint64_t count_ = 0;
  bool is_kept_ = false;  // this frame

  mutable std::mutex mutex_;  // guards the rest
  std::vector<Setup> setups_;
  std::uint32_t next_number_ = 0;
  std::shared_ptr<ImageRing> ring_of_setups_;
};

}  // namespace sslv
