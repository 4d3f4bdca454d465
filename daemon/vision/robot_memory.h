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

/// Where robots were in the last images of one camera, to look there first.
class RobotMemory {
 public:
  struct Entry {
    Team team;
    std::uint8_t id;  // as wide as ids are: whatever a recording says is one
    double x_mm, y_mm, orientation_rad;
    double x_mm_s, y_mm_s, turn_rad_s;  // 0 until seen twice
    double seen_s;                      // when the row that shows it was exposed
    double frame_s;                     // time of that frame
    // Since it was seen thrice, over the last two intervals; and how long the last one was.
    double x_mm_s2 = 0, y_mm_s2 = 0, turn_rad_s2 = 0, interval_s = 0;

    /// Where it is at a later time if it goes on as it did.
    PatternPose at(double t_s) const {
      const double dt = t_s - seen_s;
      return {x_mm + x_mm_s * dt, y_mm + y_mm_s * dt, orientation_rad + turn_rad_s * dt};
    }
    /// Where it was at its frame's time.
    PatternPose at_frame() const {
      // The mean speed between then and when it was seen; the one that is known is the last interval's.
      const double delay = seen_s - frame_s, later = (interval_s - delay) / 2;
      return {x_mm - (x_mm_s + x_mm_s2 * later) * delay, y_mm - (y_mm_s + y_mm_s2 * later) * delay,
              orientation_rad - (turn_rad_s + turn_rad_s2 * later) * delay};
    }
  };

  /// Forgets what is older than `keep_s`, and all when time has gone back.
  void forget(double now_s, double keep_s) noexcept;
  /// `robots` are where the image's rows saw them.
  void remember(const RobotList& robots, double now_s, const RowTimes& rows = {}) noexcept;
  /// Moves the robots that were just remembered to where they were at the frame's time, as far as their speed
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
