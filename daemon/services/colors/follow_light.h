// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "colors/light_follower.h"
#include "geometry/scene.h"
#include "services/cameras/fresh_frames.h"
#include "vision/lut.h"
#include "vision/patterns.h"

#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <stop_token>
#include <thread>
#include <vector>

namespace sslv {

/// Adapts each camera's colour table to the light a few times a second, using the camera's newest processed
/// frame, in one thread of low priority. At idle priority, the thread would starve if browser and service
/// share two cores. Thread-safe.
class FollowLight {
 public:
  /// Current settings of a camera.
  struct Camera {
    int id;
    FollowLightParams params;
    std::shared_ptr<const Lut> accepted;  // the settings' table, even if an adapted table is in use
    std::shared_ptr<const Scene> scene;
    std::shared_ptr<const PatternTable> patterns;
  };
  /// Callbacks, all called from thread_.
  struct Hooks {
    WaitFrame wait_frame;
    std::function<std::vector<Camera>()> cameras;
    std::function<bool()> game_is_running;
    /// Applies a table made from `accepted`, or `accepted` itself. Does nothing if `accepted` is no longer
    /// the settings' table.
    std::function<void(int camera_id, const std::shared_ptr<const Lut>& accepted,
                       std::shared_ptr<const Lut> table)>
        put_table;
  };
  struct Status {
    LightState state;
    std::deque<LightStep> steps;  // oldest first
  };

  explicit FollowLight(Hooks hooks, std::chrono::milliseconds between_looks = std::chrono::milliseconds(200));

  /// Starts stopping without waiting; the destructor waits.
  void ask_to_stop() { thread_.request_stop(); }

  /// State of a camera; LightFollowing::kOff if its table does not follow the light.
  Status status(int camera_id) const;
  /// Restores the accepted table until following is switched off and on again. thread_ applies it soon after
  /// the call; no adapted table is applied once the call has returned.
  void take_back(int camera_id);

 private:
  struct Followed {
    explicit Followed(std::shared_ptr<const Lut> accepted) : follower(std::move(accepted)) {}
    LightFollower follower;
    std::uint64_t version = 0;  // version of the last frame observed
    /// The newest tables, kept until cameras have certainly released them: otherwise a camera's thread might
    /// have to free megabytes, which takes as long as a frame.
    std::deque<std::shared_ptr<const Lut>> tables;
  };
  void serve(const std::stop_token& ending);
  void look_at(const Camera& camera, Followed& followed, bool take_back);
  bool is_to_be_taken_back(int camera_id) const;

  const Hooks hooks_;
  const std::chrono::milliseconds between_looks_;
  std::map<int, Followed> followed_;  // by camera id; used only by thread_
  std::mutex putting_;                // held while a table is applied; locked before mutex_
  mutable std::mutex mutex_;          // guards the members below
  std::condition_variable_any ordered_;
  std::set<int> to_take_back_;
  std::map<int, Status> statuses_;
  std::jthread thread_;  // last: the thread uses all members above
};

}  // namespace sslv
