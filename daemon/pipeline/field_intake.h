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

/// One camera's way to the field, or that of all cameras of other computers: lists of what was seen, handed
/// over without waiting. What the field does not take in time is lost, and counted.
class SightingsQueue {
 public:
  explicit SightingsQueue(std::shared_ptr<Bell> bell);

  /// What a camera of this computer found in an image; nothing of one without a calibration. For the
  /// camera's thread: takes no lock and no memory.
  void hand_over(const FrameInfo& info, const Scene& scene, const RobotList& robots,
                 const BallList& balls) noexcept;
  /// An image of another computer's camera, validated. For the thread that listens.
  void hand_over(const ArrivedSightings& heard) noexcept;

  std::uint64_t lost() const { return lost_.load(std::memory_order_relaxed); }

  // For the field's thread.
  const ArrivedSightings* to_read() const noexcept { return queue_.to_read(); }
  void read() noexcept { queue_.read(); }

 private:
  ArrivedSightings* begin() noexcept;
  void end(ArrivedSightings& slot) noexcept;

  // At 100 images a second, more than a tenth of a second.
  static constexpr std::size_t kSlots = 16;
  SlotQueue<ArrivedSightings, kSlots> queue_;
  std::atomic<std::uint64_t> lost_{0};
  const std::shared_ptr<Bell> bell_;
};

/// All cameras' ways to the field.
class FieldIntake {
 public:
  using Queues = std::vector<std::shared_ptr<SightingsQueue>>;

  /// Another one, which lasts as long as anybody but the intake holds it.
  std::shared_ptr<SightingsQueue> add();
  /// Lets go of those that nobody else holds any more. Called once a second.
  void drop_unused();
  /// What all queues have lost.
  std::uint64_t lost() const;

  // For the field's thread.
  /// Calls `use` with what came first, of all that has come; false when nothing has.
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
  mutable std::mutex mutex_;       // of those that add and drop; never of a camera's thread or the field's
  std::uint64_t lost_before_ = 0;  // by those that are gone
  Handover<Queues> queues_{Queues{}};
};

}  // namespace sslv
