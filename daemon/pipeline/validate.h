// SPDX-License-Identifier: Apache-2.0
#pragma once

// The only validator of results of library stages, in any process, and of packets of other visions
// (net/vision_message.h). Drops and counts values that are not finite or are outside the limits in
// geometry/limits.h. The stack runs it after each stage, so packets, viewers and later stages need no further
// checks. It does not judge the uncertainty of positions: Gather does.

#include "geometry/limits.h"
#include "image/frame_info.h"
#include "tracking/sightings.h"
#include "tracking/tracks.h"
#include "vision/detections.h"

#include <atomic>
#include <cstddef>
#include <cstdint>

#include <Eigen/Core>

namespace sslv {

/// Counts of dropped results.
struct InvalidCounts {
  std::uint64_t robots = 0, balls = 0;
  std::uint64_t others = 0;  // times, kicks

  /// True if one of the counts is not 0.
  bool any() const { return (robots | balls | others) != 0; }
  InvalidCounts& operator+=(const InvalidCounts& more) {
    robots += more.robots;
    balls += more.balls;
    others += more.others;
    return *this;
  }
};

/// Totals since the start. Any thread adds and reads without a lock.
class InvalidTotals {
 public:
  void add(const InvalidCounts& more) noexcept {
    robots_.fetch_add(more.robots, std::memory_order_relaxed);
    balls_.fetch_add(more.balls, std::memory_order_relaxed);
    others_.fetch_add(more.others, std::memory_order_relaxed);
  }
  InvalidCounts read() const {
    return {robots_.load(std::memory_order_relaxed), balls_.load(std::memory_order_relaxed),
            others_.load(std::memory_order_relaxed)};
  }

 private:
  std::atomic<std::uint64_t> robots_{0}, balls_{0}, others_{0};
};

bool is_valid(const CaptureTimes& times) noexcept;
/// Whether `info`, which a stage has changed, still describes the camera's image. Its time may be corrected
/// by a few seconds.
bool is_valid(const FrameInfo& info, const FrameInfo& of_camera) noexcept;
/// False for (0, 0, 0), the position of a camera that is not calibrated.
bool is_camera_place(const Eigen::Vector3d& place_mm) noexcept;
bool is_valid(const Robot& robot) noexcept;
bool is_valid(const RobotMiss& miss) noexcept;
bool is_valid(const Ball& ball) noexcept;
bool is_valid(const TrackedRobot& robot) noexcept;
bool is_valid(const TrackedBall& ball) noexcept;
bool is_valid(const TrackedKick& kick) noexcept;

// These functions keep the order of the remaining entries and the lists' memory. Lists longer than the limit
// are truncated.
InvalidCounts drop_invalid(RobotList& list) noexcept;
InvalidCounts drop_invalid(BallList& list) noexcept;
/// Drops the whole image if its time, its camera's id or its camera's position is invalid.
InvalidCounts drop_invalid(CameraSightings& image) noexcept;
InvalidCounts drop_invalid(Observations& observations) noexcept;
InvalidCounts drop_invalid(ImageTime& time) noexcept;
/// If the time is not finite, drops everything and sets the time to 0.
InvalidCounts drop_invalid(TrackedField& tracked) noexcept;

}  // namespace sslv
