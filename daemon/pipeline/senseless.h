// SPDX-License-Identifier: Apache-2.0
#pragma once

// The one validator of what stages of libraries make, in whatever process they run, and of what packets of
// other visions say (net/vision_message.h). It drops and counts what is not finite or outside
// geometry/limits.h. The stack runs it after each stage, so packets, viewers and later stages check nothing
// again. It does not judge how certain a place is: Gather does.

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

/// How much of it was dropped.
struct Senseless {
  std::uint64_t robots = 0, balls = 0;
  std::uint64_t others = 0;  // times, kicks

  bool any() const { return (robots | balls | others) != 0; }
  Senseless& operator+=(const Senseless& more) {
    robots += more.robots;
    balls += more.balls;
    others += more.others;
    return *this;
  }
};

/// The same since the start. Any thread adds without a lock, and any reads.
class SenselessTotals {
 public:
  void add(const Senseless& more) noexcept {
    robots_.fetch_add(more.robots, std::memory_order_relaxed);
    balls_.fetch_add(more.balls, std::memory_order_relaxed);
    others_.fetch_add(more.others, std::memory_order_relaxed);
  }
  Senseless read() const {
    return {robots_.load(std::memory_order_relaxed), balls_.load(std::memory_order_relaxed),
            others_.load(std::memory_order_relaxed)};
  }

 private:
  std::atomic<std::uint64_t> robots_{0}, balls_{0}, others_{0};
};

bool makes_sense(const CaptureTimes& times) noexcept;
/// What a stage made of what the camera said of its image: it is still about that image. Its time may be
/// corrected, by a few seconds.
bool makes_sense(const FrameInfo& info, const FrameInfo& of_camera) noexcept;
/// False for (0, 0, 0), of a camera that is not calibrated.
bool is_camera_place(const Eigen::Vector3d& place_mm) noexcept;
bool makes_sense(const Robot& robot) noexcept;
bool makes_sense(const Ball& ball) noexcept;
bool makes_sense(const TrackedRobot& robot) noexcept;
bool makes_sense(const TrackedBall& ball) noexcept;
bool makes_sense(const TrackedKick& kick) noexcept;

// They keep the order of the rest, and its memory. Of a list that is too long, the first stay.
Senseless drop_senseless(RobotList& list) noexcept;
Senseless drop_senseless(BallList& list) noexcept;
/// An image without a time, a camera's id or its place is left out.
Senseless drop_senseless(CameraSightings& image) noexcept;
Senseless drop_senseless(Observations& observations) noexcept;
Senseless drop_senseless(ImageTime& time) noexcept;
/// Without a time, nothing of it makes sense: it is empty then, and its time is 0.
Senseless drop_senseless(TrackedField& tracked) noexcept;

}  // namespace sslv
