// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/futex.h"
#include "base/handover.h"
#include "base/slot_queue.h"
#include "geometry/scene.h"
#include "image/frame_info.h"
#include "tracking/sightings.h"
#include "vision/detections.h"

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

namespace sslv {

/// Passes measurements of one camera, or of all cameras of other computers, to the field's thread without
/// waiting. Images that the field does not read in time are lost and counted.
class SightingsQueue {
 public:
  explicit SightingsQueue(std::shared_ptr<Bell> bell);

  /// Adds the detections of an image of a camera of this computer; ignored if the camera is not calibrated.
  /// For the camera's thread: takes no lock and allocates nothing.
  void hand_over(const FrameInfo& info, const Scene& scene, const RobotList& robots,
                 const BallList& balls) noexcept;
  /// Adds a validated image of another computer's camera. For the receiving thread.
  void hand_over(const ArrivedSightings& heard) noexcept;

  std::uint64_t lost() const { return lost_.load(std::memory_order_relaxed); }

  // For the field's thread.
  const ArrivedSightings* to_read() const noexcept { return queue_.to_read(); }
  void read() noexcept { queue_.read(); }

 private:
  ArrivedSightings* begin() noexcept;
  void end(ArrivedSightings& slot) noexcept;

  // Enough for more than 0.1 s at 100 images a second.
  static constexpr std::size_t kSlots = 16;
  SlotQueue<ArrivedSightings, kSlots> queue_;
  std::atomic<std::uint64_t> lost_{0};
  const std::shared_ptr<Bell> bell_;
};

/// The queues of all cameras to the field's thread.
class FieldIntake {
 public:
  using Queues = std::vector<std::shared_ptr<SightingsQueue>>;

  /// Adds a queue. The queue is kept while anyone besides the intake holds it.
  std::shared_ptr<SightingsQueue> add();
  /// Removes the queues that only the intake still holds. Called once a second.
  void drop_unused();
  /// Images lost by all queues.
  std::uint64_t lost() const;

  // For the field's thread.
  /// Calls `use` with the queued image that was captured first; returns false if all queues are empty.
  template <class Use>
  bool take(const Use& use) {
    const auto queues = queues_.use();
    SightingsQueue* first = nullptr;
    for (const auto& queue : *queues) {
      const ArrivedSightings* const next = queue->to_read();
      if (!next) continue;
      if (!first || next->image.t_capture_s < first->to_read()->image.t_capture_s) first = queue.get();
    }
    if (!first) return false;
    use(*first->to_read());
    first->read();
    return true;
  }
  std::uint32_t mark() const noexcept { return bell_->mark(); }
  void wait(std::uint32_t mark, std::chrono::steady_clock::time_point until) const noexcept {
    bell_->wait(mark, until);
  }
  /// Wakes the field's thread.
  void ring() noexcept { bell_->ring(); }

 private:
  const std::shared_ptr<Bell> bell_ = std::make_shared<Bell>();
  mutable std::mutex mutex_;  // for adding and removing; not locked by cameras' threads or the field's thread
  std::uint64_t lost_before_ = 0;  // images lost by removed queues
  Handover<Queues> queues_{Queues{}};
};

}  // namespace sslv
