// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "health/computer.h"
#include "health/exposure.h"
#include "health/timeline.h"
#include "running_camera.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

namespace sslv {

/// Looks at the cameras and the computer once a second, in a thread of low priority. May be asked from any
/// thread.
class Monitor {
 public:
  using Cameras = std::vector<std::shared_ptr<RunningCamera>>;

  /// Starts at once. `cameras`: those there are now; `then`: called after each look. `state_folder`: whose
  /// disk is looked at.
  Monitor(const std::filesystem::path& state_folder, std::function<Cameras()> cameras,
          std::function<void()> then);

  const Timeline& timeline() const { return timeline_; }
  ComputerFigures computer() const;
  std::optional<ClockFigures> clock() const;
  /// Of the camera's newest picture; none when none came in the last second.
  std::optional<Exposure> exposure(int camera_id) const;

 private:
  struct Seen {  // of a camera, up to the last look
    std::weak_ptr<RunningCamera> camera;
    std::uint64_t picture = 0, latencies = 0, ages = 0;
  };
  void look();
  Timeline::Reading read(const RunningCamera& camera, Seen& seen) const;

  const std::function<Cameras()> cameras_;
  const std::function<void()> then_;
  Computer computer_reader_;  // this and the next: of the thread alone
  std::map<int, Seen> seen_;
  Timeline timeline_;
  mutable std::mutex mutex_;  // guards the three below
  ComputerFigures computer_;
  std::optional<ClockFigures> clock_;
  std::map<int, Exposure> exposures_;
  std::jthread thread_;  // last, so that it ends before what it uses
};

}  // namespace sslv
