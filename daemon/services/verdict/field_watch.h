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

/// How the painted lines lie in a camera's newest images.
struct LinesNow {
  LinesVerdict verdict;
  std::string worst_line;                    // its name
  const FieldPreset* better_size = nullptr;  // see find_better_size()
};

/// Looks at each camera's newest finished frame ten times a second, in one thread of low priority: at what
/// was found in it, and every few looks at its painted lines. May be used from any thread.
class FieldWatch {
 public:
  struct Pace {
    std::chrono::milliseconds between_looks = std::chrono::milliseconds(100);
    std::chrono::milliseconds between_lines = std::chrono::milliseconds(1500);
  };
  struct Seen {
    FieldSeen field;
    std::map<int, LinesNow> lines;  // by camera id; none where no line can be judged
    double watched_s = 0;           // for so long
  };

  /// `cameras` must outlive this.
  explicit FieldWatch(Cameras& cameras, Pace pace);
  explicit FieldWatch(Cameras& cameras) : FieldWatch(cameras, Pace{}) {}

  /// Begins what the destructor does, and does not wait for it.
  void ask_to_stop() { thread_.request_stop(); }

  /// See Sightings::now().
  Seen seen(std::optional<double> match_since_s, const SubstitutionAreas& areas) const;
  /// Of cameras that show something else from now on, or are gone.
  void forget(const std::set<int>& camera_ids);
  /// See Sightings.
  void robots_are_handled(bool are);
  /// Of cameras that are gone, or whose place another one took.
  void expect_nothing_of(const std::set<int>& camera_ids);

 private:
  using Clock = std::chrono::steady_clock;
  /// What its own thread keeps of a camera.
  struct Watched {
    std::uint64_t version = 0;               // of the frame that was looked at last
    std::shared_ptr<const Scene> seen_with;  // what stood in that frame, where
    Clock::time_point lines_due{};
    std::shared_ptr<const Scene> scene;  // that the next two are of
    std::optional<FieldCurves> curves;   // of its field
    std::optional<LinesNow> before;      // what was seen of the lines the last time
  };
  void serve(const std::stop_token& ending);
  void look_at(const CameraNow& camera, Watched& watched);
  void look_at_lines(const CameraNow& camera, const LentFrame& frame, Watched& watched);

  Cameras& cameras_;
  const Pace pace_;
  const double started_s_;
  mutable std::mutex mutex_;  // guards what follows
  Sightings sightings_;
  std::map<int, LinesNow> lines_;
  std::set<int> to_forget_;
  std::jthread thread_;  // last: it uses all the others
};

}  // namespace sslv
