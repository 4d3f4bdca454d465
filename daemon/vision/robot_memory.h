// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/detections.h"
#include "vision/pattern_pose.h"
#include "vision/row_times.h"

#include <cstddef>
#include <cstdint>
#include <tuple>
#include <vector>

namespace sslv {

/// Poses of robots in the last images of one camera, used as start poses for finding the robots again.
class RobotMemory {
 public:
  struct Entry {
    Team team;
    std::uint8_t id;  // 8 bits, so that any value in a recording is a valid id
    double x_mm, y_mm, orientation_rad;
    double x_mm_s, y_mm_s, turn_rad_s;  // 0 until seen twice
    double seen_s;                      // exposure time of the row that shows the robot
    double frame_s;                     // time of the frame that shows the robot
    // Accelerations over the last two intervals, 0 until seen three times, and the length of the last
    // interval.
    double x_mm_s2 = 0, y_mm_s2 = 0, turn_rad_s2 = 0, interval_s = 0;

    /// Predicted pose at a later time, at constant velocity.
    PatternPose at(double t_s) const {
      const double dt = t_s - seen_s;
      return {x_mm + x_mm_s * dt, y_mm + y_mm_s * dt, orientation_rad + turn_rad_s * dt};
    }
    /// Pose at its frame's time.
    PatternPose at_frame() const {
      // Uses the mean velocity between the frame's time and seen_s, derived from the velocity and
      // acceleration over the last interval.
      const double delay = seen_s - frame_s, later = (interval_s - delay) / 2;
      return {x_mm - (x_mm_s + x_mm_s2 * later) * delay, y_mm - (y_mm_s + y_mm_s2 * later) * delay,
              orientation_rad - (turn_rad_s + turn_rad_s2 * later) * delay};
    }
  };

  /// Forgets entries older than `keep_s`, and entries that are not older than `now_s` because the time has
  /// jumped back.
  void forget(double now_s, double keep_s) noexcept;
  /// `robots` have the positions at which the image's rows show them.
  void remember(const RobotList& robots, double now_s, const RowTimes& rows = {}) noexcept;
  /// Moves the robots that were just remembered to their pose at the frame's time, as far as their velocity
  /// is known.
  void move_to_frame(RobotList& robots) const noexcept;
  const std::vector<Entry>& entries() const { return entries_; }

  template <class Self>
  static auto stored(Self& self) {
    return std::tie(self.entries_);
  }

 private:
  std::vector<Entry> entries_;
};

}  // namespace sslv
