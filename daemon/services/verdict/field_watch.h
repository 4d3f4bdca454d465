// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/check_lines.h"
#include "calibration/painted_curves.h"
#include "services/cameras/cameras.h"
#include "services/verdict/sightings.h"

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

namespace sslv {

/// Offsets of the painted lines in a camera's newest images.
struct LinesNow {
  LinesVerdict verdict;
  std::string worst_line;                    // name of the line that is farthest off
  const FieldPreset* better_size = nullptr;  // see find_better_size()
};

/// Checks each camera's newest processed frame ten times a second, in one thread of low priority: its
/// detections and, less often, the painted lines. Thread-safe.
class FieldWatch {
 public:
  struct Pace {
    std::chrono::milliseconds between_looks = std::chrono::milliseconds(100);
    std::chrono::milliseconds between_lines = std::chrono::milliseconds(1500);
  };
  struct Seen {
    FieldSeen field;
    std::map<int, LinesNow> lines;  // by camera id; only cameras with a line that can be judged
    double watched_s = 0;           // time since the watch was started
  };

  /// `cameras` must outlive this.
  explicit FieldWatch(Cameras& cameras, Pace pace);
  explicit FieldWatch(Cameras& cameras) : FieldWatch(cameras, Pace{}) {}

  /// Starts stopping without waiting; the destructor waits.
  void ask_to_stop() { thread_.request_stop(); }

  /// See Sightings::now().
  Seen seen(std::optional<double> match_since_s, const SubstitutionAreas& areas) const;
  /// Drops the data of cameras that were removed or whose view has changed.
  void forget(const std::set<int>& camera_ids);
  /// See Sightings.
  void robots_are_handled(bool are);
  /// For cameras that were removed or replaced. See Sightings.
  void expect_nothing_of(const std::set<int>& camera_ids);

 private:
  using Clock = std::chrono::steady_clock;
  /// State of a camera, used only by thread_.
  struct Watched {
    std::uint64_t version = 0;               // version of the last frame checked
    std::shared_ptr<const Scene> seen_with;  // scene of that frame's detections
    Clock::time_point lines_due{};
    std::shared_ptr<const Scene> scene;  // scene that `curves` and `before` belong to
    std::optional<FieldCurves> curves;   // curves of the scene's field
    std::optional<LinesNow> before;      // result of the previous check of the lines
  };
  void serve(const std::stop_token& ending);
  void look_at(const CameraNow& camera, Watched& watched);
  void look_at_lines(const CameraNow& camera, const LentFrame& frame, Watched& watched);

  Cameras& cameras_;
  const Pace pace_;
  const double started_s_;
  mutable std::mutex mutex_;  // guards the members below
  Sightings sightings_;
  std::map<int, LinesNow> lines_;
  std::set<int> to_forget_;
  std::jthread thread_;  // last: the thread uses all members above
};

}  // namespace sslv
