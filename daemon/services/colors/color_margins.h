// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "colors/surfaces.h"
#include "geometry/scene.h"
#include "services/cameras/fresh_frames.h"
#include "vision/lut.h"
#include "vision/mask.h"
#include "vision/patterns.h"

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <stop_token>
#include <thread>
#include <utility>
#include <vector>

namespace sslv {

/// Colours of the large surfaces (carpet, floor and others) in a frame, without the robots and balls detected
/// there. Also works for uncalibrated cameras.
SurfaceColors surfaces_of(const LentFrame& frame, const Scene& scene, const PatternTable& patterns,
                          const Mask* mask, const std::stop_token& stop = {});

/// Measures the colours of carpet and floor in each camera's frames every few seconds, and the margins
/// between these colours and the camera's colour table, in one thread of low priority. Thread-safe.
class ColorMargins {
 public:
  using Clock = std::chrono::steady_clock;
  /// Current settings of a camera.
  struct Camera {
    int id;
    std::shared_ptr<const Lut> lut;
    std::shared_ptr<const Scene> scene;
    std::shared_ptr<const Mask> mask;
    std::shared_ptr<const PatternTable> patterns;
  };
  /// Callbacks, all called from thread_.
  struct Hooks {
    WaitFrame wait_frame;
    std::function<std::vector<Camera>()> cameras;
  };
  struct Pace {
    std::chrono::milliseconds between_looks = std::chrono::seconds(5);
    std::chrono::milliseconds between_rounds = std::chrono::milliseconds(500);
  };

  explicit ColorMargins(Hooks hooks, Pace pace);
  explicit ColorMargins(Hooks hooks) : ColorMargins(std::move(hooks), Pace{}) {}

  /// Starts stopping without waiting; the destructor waits.
  void ask_to_stop() { thread_.request_stop(); }

  /// The surfaces measured last; null before the first measurement, and for a camera without colours.
  std::shared_ptr<const SurfaceColors> surfaces(int camera_id) const;
  /// Returns the margins of the camera's current table, or of a table that may replace it. Takes tens of
  /// milliseconds if they were not computed before. Returns nothing while the camera's surfaces are unknown,
  /// or when stopped.
  std::optional<std::vector<LabelMargin>> margins(int camera_id, const Lut& lut,
                                                  const std::stop_token& stop = {});
  /// The margins computed last.
  std::optional<std::vector<LabelMargin>> newest_margins(int camera_id) const;
  /// Drops the data of cameras that were removed or whose view has changed.
  void forget(const std::set<int>& camera_ids);

 private:
  struct Known {
    std::shared_ptr<const SurfaceColors> surfaces;  // null: not measured yet
    std::vector<LabelMargin> margins;               // margins between a table and these surfaces
    std::uint64_t lut_id = 0;                       // Lut::id of that table
  };
  /// State of a camera, used only by thread_.
  struct Look {
    std::shared_ptr<Known> known{};
    std::shared_ptr<const Scene> scene{};  // scene at the last measurement
    std::shared_ptr<const Mask> mask{};
    std::uint64_t version = 0;  // version of the last measured frame
    Clock::time_point next{}, next_count{};
  };
  void serve(const std::stop_token& ending);
  void look_at(const Camera& camera, Look& look, const std::stop_token& ending);
  /// False when there is no new frame with colours.
  bool see_surfaces(const Camera& camera, Look& look, const std::stop_token& ending);

  const Hooks hooks_;
  const Pace pace_;
  std::map<int, Look> looks_;  // by camera id; used only by thread_
  mutable std::mutex mutex_;   // guards the members below
  std::condition_variable_any rests_;
  std::map<int, std::shared_ptr<Known>> known_;  // by camera id
  std::jthread thread_;                          // last: the thread uses all members above
};

}  // namespace sslv
