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

/// What a camera's frames are processed with, swapped as a whole between two frames.
struct CameraSetup {
  std::shared_ptr<Pipeline> pipeline;
  Pipeline::Parameters parameters;
  CameraContext context;
  std::uint32_t number = 0;  // of this camera's setups, in the order in which they came
};

/// Is told of every frame by the camera's thread, with all that it is processed with. Must neither wait nor
/// allocate.
class FrameObserver {
 public:
  virtual ~FrameObserver() = default;
  /// Before the first stage.
  virtual void frame_begins(const CameraSetup&) noexcept {}
  /// After the last one. The frame's image and lists are valid during the call.
  virtual void frame_ends(const Frame&, const CameraSetup&) noexcept {}
};

/// One camera's way from image to published detections: numbers the frames, runs the stack, offers the
/// finished frame to viewers. `process` and `give_back` are called by one thread, the camera's, which waits
/// for no other; the rest is for any other thread.
class CameraPipeline {
 public:
  struct Counters {
    std::uint64_t frames = 0;             // processed
    std::uint64_t capped = 0;             // of them flagged: a list hit its cap
    std::uint64_t unseen = 0;             // of them not offered to viewers, who held all of the ring
    std::uint32_t robots = 0, balls = 0;  // in the newest frame
    Flood flood;                          // the newest one, and how many frames ago it was
    std::uint64_t frames_since_flood = 0;
  };

  /// `sink` and `observer` must outlive this; null: there is no observer.
  CameraPipeline(std::uint32_t camera_id, DetectionSink& sink, CameraSetup setup,
                 FrameObserver* observer = nullptr);

  /// Takes effect with the next frame.
  void change(CameraSetup setup) { setup_.store(std::move(setup)); }
  std::shared_ptr<const CameraSetup> setup() const { return setup_.load(); }

  /// The next frame gets this number, those after it the following ones: for who processes recorded frames
  /// again. Before process(), by the same thread.
  void set_next_number(std::uint32_t number) { next_number_ = number; }
  /// Runs the stack on one image. The result is valid until the next call.
  const Frame& process(Image image, const CaptureTimes& times, const WholePicture& whole = {}) noexcept;

  /// Finished frames, the newest only.
  const LatestFrame& finished() const { return finished_; }
  /// Gives the driver the buffers back of what viewers have let go of; for when no image comes to process.
  /// True while viewers hold others.
  bool give_back() noexcept;
  /// Lets go of the newest frame and wakes all who wait for one. Not while the camera's thread runs.
  void close();

  Counters counters() const { return counters_.load(); }

 private:
  // The newest frame, the one being processed, and one each for a few viewers' tasks.
  static constexpr std::size_t kRingSlots = 8;

  /// What counters() tells: added to by the camera's thread, read by any, without a lock.
  class FrameCounters {
   public:
    void add(const Frame& frame) noexcept;
    /// The last one was not offered to viewers.
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
  Frame spare_;  // used when viewers hold the whole ring: never offered
  FrameRef current_;
  LatestFrame finished_{ring_};
  std::uint32_t next_number_ = 0;
  FrameCounters counters_;
};

}  // namespace sslv
