// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "health/exposure.h"
#include "health/timeline.h"
#include "services/cameras/running_camera.h"
#include "services/stage_watch.h"

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

namespace sslv {

/// Measures the cameras once a second. look() is for one thread only; all other functions are thread-safe.
class CameraWatch {
 public:
  /// Call it once a second.
  void look(const std::vector<std::shared_ptr<RunningCamera>>& cameras);

  const Timeline& timeline() const { return timeline_; }
  /// Exposure of the camera's newest frame; none if no frame arrived in the last second.
  std::optional<Exposure> exposure(int camera_id) const;
  /// Figures of the stages of the camera's stack over the last seconds.
  std::vector<StageFigures> stages(int camera_id) const;

 private:
  struct Seen {  // state of a camera at the last look()
    std::weak_ptr<RunningCamera> camera;
    std::uint64_t frame = 0, latencies = 0, ages = 0;
    StageWatch stages{};
  };
  static Timeline::Reading read(const RunningCamera& camera, Seen& seen);

  std::map<int, Seen> seen_;  // used by the thread that calls look()
  Timeline timeline_;
  mutable std::mutex mutex_;  // guards the members below
  std::map<int, Exposure> exposures_;
  std::map<int, std::vector<StageFigures>> stages_;
};

}  // namespace sslv
