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

/// What was seen of the cameras, second by second. look() is for one thread, the rest for any.
class CameraWatch {
 public:
  /// Once a second.
  void look(const std::vector<std::shared_ptr<RunningCamera>>& cameras);

  const Timeline& timeline() const { return timeline_; }
  /// Of the camera's newest frame; none when none came in the last second.
  std::optional<Exposure> exposure(int camera_id) const;
  /// Of the camera's stack, as they were in the last seconds.
  std::vector<StageFigures> stages(int camera_id) const;

 private:
  struct Seen {  // of a camera, up to the last look
    std::weak_ptr<RunningCamera> camera;
    std::uint64_t frame = 0, latencies = 0, ages = 0;
    StageWatch stages{};
  };
  static Timeline::Reading read(const RunningCamera& camera, Seen& seen);

  std::map<int, Seen> seen_;  // of the thread that looks
  Timeline timeline_;
  mutable std::mutex mutex_;  // guards what follows
  std::map<int, Exposure> exposures_;
  std::map<int, std::vector<StageFigures>> stages_;
};

}  // namespace sslv
