// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/detections.h"
#include "vision/pattern_pose.h"

#include <cstddef>
#include <vector>

namespace sslv {

/// Where robots were in the last pictures of one camera, to look there first.
class RobotMemory {
 public:
  struct Entry {
    Team team;
    int id;
    double x_mm, y_mm, orientation_rad;
    double x_mm_s, y_mm_s, turn_rad_s;  // 0 until seen twice
    double seen_s;

    /// Where it is at a later time if it goes on as it did.
    PatternPose at(double t_s) const {
      const double dt = t_s - seen_s;
      return {x_mm + x_mm_s * dt, y_mm + y_mm_s * dt, orientation_rad + turn_rad_s * dt};
    }
  };

  /// Forgets what is older than `keep_s`, and all when time has gone back.
  void forget(double now_s, double keep_s) noexcept;
  void remember(const RobotList& robots, double now_s) noexcept;
  const std::vector<Entry>& entries() const { return entries_; }

 private:
  std::vector<Entry> entries_;
};

}  // namespace sslv
