// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "geometry/scene.h"
#include "net/packets.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace sslv {

/// Larger differences count as moved.
struct CompareLimits {
  double moved_mm = 1;
  double turned_deg = 1;
};

/// A robot or ball that only one run found, or that differs between the runs.
struct ClipDifference {
  enum class Kind { kFound, kLost, kMoved, kIdChanged };
  Kind kind{};
  std::optional<Team> team{};         // none: a ball
  int id_before = -1, id_after = -1;  // a robot's ids; -1: none
  double x_mm = 0, y_mm = 0;          // in the run "after"; in "before" if lost
  double moved_mm = 0, turned_deg = 0;
  double pixel_x = 0, pixel_y = 0;  // in the image, from the same run as x_mm
};

/// A frame in which the two runs differ.
struct FrameDifferences {
  std::uint32_t number = 0;
  double t_capture_s = 0;
  std::vector<ClipDifference>
      differences{};  // empty: only the packets' bytes differ, by less than the limits
};

struct DifferenceCounts {
  std::uint64_t before = 0, after = 0;  // number of detections in all frames together
  std::uint64_t found = 0, lost = 0, moved = 0, id_changed = 0;
  double max_moved_mm = 0, max_turned_deg = 0;  // including differences below the limits
};

/// Compares the packets of two runs over the same frames, "before" and "after".
class ClipComparison {
 public:
  /// Frames that differ are kept up to this number; all are counted.
  static constexpr std::size_t kMaxKept = 10'000;

  explicit ClipComparison(const CompareLimits& limits = {}) : limits_(limits) {}

  /// Adds both packets of one frame. Robots are associated by team and id first, and the remaining robots by
  /// team; balls by position. In each step, the nearest pairs are associated first, up to 100 mm. An empty or
  /// invalid packet counts as a packet without robots and balls.
  void add(std::span<const std::byte> before, std::span<const std::byte> after);

  std::uint64_t frames() const { return frames_; }
  std::uint64_t frames_with_other_bytes() const { return frames_with_other_bytes_; }
  /// Frames with any ClipDifference.
  std::uint64_t frames_that_differ() const { return frames_that_differ_; }
  const DifferenceCounts& robots() const { return robots_; }
  const DifferenceCounts& balls() const { return balls_; }
  const std::vector<FrameDifferences>& different_frames() const { return kept_; }

 private:
  const CompareLimits limits_;
  std::uint64_t frames_ = 0, frames_with_other_bytes_ = 0, frames_that_differ_ = 0;
  DifferenceCounts robots_, balls_;
  std::vector<FrameDifferences> kept_;
  SSL_WrapperPacket before_, after_;  // kept to reuse their memory
};

/// {"frames", "frames_with_other_bytes", "frames_that_differ", "robots": {...counts}, "balls": {...},
/// "differences": [{"frame", "t_capture", "what": [{"kind": "found" | "lost" | "moved" | "id_changed",
/// "team", "id", "id_before", "x", "y", "moved_mm", "turned_deg"}]}]}; a ball has no team and no ids.
Json comparison_json(const ClipComparison& comparison);

}  // namespace sslv
