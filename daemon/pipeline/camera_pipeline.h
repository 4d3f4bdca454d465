// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/handover.h"
#include "pipeline/frame_ring.h"
#include "pipeline/latest_frame.h"
#include "pipeline/pipeline.h"

#include <atomic>
#include <cstdint>
#include <memory>

namespace sslv {

/// The configuration for one camera's frames; replaced as a whole between two frames.
struct CameraSetup {
  std::shared_ptr<Pipeline> pipeline;
  Pipeline::Parameters parameters;
  CameraContext context;
  std::uint32_t number = 0;  // counts this camera's setups
};

/// Called by the camera's thread for every frame, with the setup that processes it. Must neither wait nor
/// allocate.
class FrameObserver {
 public:
  virtual ~FrameObserver() = default;
  /// Called before the first stage.
  virtual void frame_begins(const CameraSetup&) noexcept {}
  /// Called after the last stage. The frame's image and lists are valid during the call.
  virtual void frame_ends(const Frame&, const CameraSetup&) noexcept {}
};

/// Turns one camera's images into published detections: numbers the frames, runs the stack and offers
/// finished frames to viewers. Only the camera's thread calls `process` and `give_back`, and that thread
/// waits for no other thread. The other functions are for other threads, unless they state otherwise.
class CameraPipeline {
 public:
  struct Counters {
    std::uint64_t frames = 0;             // processed frames
    std::uint64_t capped = 0;             // frames flagged because a list reached its cap
    std::uint64_t unseen = 0;             // frames not offered to viewers, who already held the whole ring
    std::uint32_t robots = 0, balls = 0;  // in the newest frame
    Flood flood;                          // the newest flood, and the number of frames since then
    std::uint64_t frames_since_flood = 0;
  };

  /// `sink` and `observer` must outlive this; `observer` may be null.
  CameraPipeline(std::uint32_t camera_id, DetectionSink& sink, CameraSetup setup,
                 FrameObserver* observer = nullptr);

  /// Takes effect with the next frame.
  void change(CameraSetup setup) { setup_.store(std::move(setup)); }
  std::shared_ptr<const CameraSetup> setup() const { return setup_.load(); }

  /// Sets the number of the next frame; later frames count on from it. For processing recorded frames again.
  /// Call before process(), on the same thread.
  void set_next_number(std::uint32_t number) { next_number_ = number; }
  /// Runs the stack on one image. The result is valid until the next call.
  const Frame& process(Image image, const CaptureTimes& times, const WholePicture& whole = {}) noexcept;

  /// The newest finished frame.
  const LatestFrame& finished() const { return finished_; }
  /// Gives buffers that viewers have released back to the driver; call it while no new images arrive. Returns
  /// true while viewers hold other buffers.
  bool give_back() noexcept;
  /// Releases the newest frame and wakes all threads that wait for one. Must not be called while the camera's
  /// thread runs.
  void close();

  Counters counters() const { return counters_.load(); }

 private:
  // Slots for the newest frame, the frame being processed, and one frame for each of a few viewers' tasks.
  static constexpr std::size_t kRingSlots = 8;

  /// Values of counters(): updated by the camera's thread, read by any thread, without a lock.
  class FrameCounters {
   public:
    void add(const Frame& frame) noexcept;
    /// Counts the last frame as not offered to viewers.
    void add_unseen() noexcept { unseen_.fetch_add(1, std::memory_order_relaxed); }
    Counters load() const;

   private:
    std::atomic<std::uint64_t> frames_{0}, capped_{0}, unseen_{0};
    std::atomic<std::uint32_t> robots_{0}, balls_{0};
    std::atomic<Flood> flood_{Flood{}};
    static_assert(std::atomic<Flood>::is_always_lock_free);
    std::atomic<std::uint64_t> flood_frame_{0};
  };

  const std::uint32_t camera_id_;
  DetectionSink& sink_;
  FrameObserver* const observer_;
  Handover<CameraSetup> setup_;
  FrameRing ring_{kRingSlots};
  Frame spare_;  // used if viewers hold the whole ring; never offered to them
  FrameRef current_;
  LatestFrame finished_{ring_};
  std::uint32_t next_number_ = 0;
  FrameCounters counters_;
};

}  // namespace sslv
