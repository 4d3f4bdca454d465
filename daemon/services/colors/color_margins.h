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

/// What is large in a frame of a calibrated or uncalibrated camera, beside the robots and balls found in it:
/// carpet, floor and others.
SurfaceColors surfaces_of(const LentFrame& frame, const Scene& scene, const PatternTable& patterns,
                          const Mask* mask, const std::stop_token& stop = {});

/// Looks at carpet and floor in each camera's frames every few seconds, in one thread of low priority, and
/// knows how far its colour table is from them. May be used from any thread.
class ColorMargins {
 public:
  using Clock = std::chrono::steady_clock;
  /// What is in effect for a camera.
  struct Camera {
    int id;
    std::shared_ptr<const Lut> lut;
    std::shared_ptr<const Scene> scene;
    std::shared_ptr<const Mask> mask;
    std::shared_ptr<const PatternTable> patterns;
  };
  /// What it asks of others, all from its own thread.
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

  /// Begins what the destructor does, and does not wait for it.
  void ask_to_stop() { thread_.request_stop(); }

  /// As they were seen last; null when they have not been, and of a camera without colours.
  std::shared_ptr<const SurfaceColors> surfaces(int camera_id) const;
  /// Of the camera's table, or of one that it is to have; counted now, in some tens of milliseconds, unless
  /// that was done already. Nothing while its surfaces are not known.
  std::optional<std::vector<LabelMargin>> margins(int camera_id, const Lut& lut,
                                                  const std::stop_token& stop = {});
  /// Those that were counted last.
  std::optional<std::vector<LabelMargin>> newest_margins(int camera_id) const;
  /// Of cameras that show something else from now on, or are gone.
  void forget(const std::set<int>& camera_ids);

 private:
  struct Known {
    std::shared_ptr<const SurfaceColors> surfaces;  // null: not seen yet
    std::vector<LabelMargin> margins;               // of a table to these surfaces
    std::uint64_t lut_id = 0;                       // of that table
  };
  /// What its own thread keeps of a camera.
  struct Look {
    std::shared_ptr<Known> known{};
    std::shared_ptr<const Scene> scene{};  // that it was looked at with
    std::shared_ptr<const Mask> mask{};
    std::uint64_t version = 0;  // of the frame
    Clock::time_point next{}, next_count{};
  };
  void serve(const std::stop_token& ending);
  void look_at(const Camera& camera, Look& look, const std::stop_token& ending);
  /// False when there is no new frame with colours.
  bool see_surfaces(const Camera& camera, Look& look, const std::stop_token& ending);

  const Hooks hooks_;
  const Pace pace_;
  std::map<int, Look> looks_;  // by camera id; its own thread's
  mutable std::mutex mutex_;   // guards what follows
  std::condition_variable_any rests_;
  std::map<int, std::shared_ptr<Known>> known_;  // by camera id
  std::jthread thread_;                          // last: it uses all the others
};

}  // namespace sslv
