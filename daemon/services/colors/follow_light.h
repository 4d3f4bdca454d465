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

/// Looks at each camera's newest finished frame a few times a second and makes its colour table follow the
/// light, in one thread of low priority; an idle one would starve where browser and service share two cores.
/// May be used from any thread.
class FollowLight {
 public:
  /// What is in effect for a camera.
  struct Camera {
    int id;
    FollowLightParams params;
    std::shared_ptr<const Lut> accepted;  // the table of the settings, whichever is in use
    std::shared_ptr<const Scene> scene;
    std::shared_ptr<const PatternTable> patterns;
  };
  /// What it asks of others, all from its own thread.
  struct Hooks {
    WaitFrame wait_frame;
    std::function<std::vector<Camera>()> cameras;
    std::function<bool()> game_is_running;
    /// Applies a table that was made of `accepted`, or `accepted` itself. Does nothing when the settings have
    /// another table than `accepted` by now.
    std::function<void(int camera_id, const std::shared_ptr<const Lut>& accepted,
                       std::shared_ptr<const Lut> table)>
        put_table;
  };
  struct Status {
    LightState state;
    std::deque<LightStep> steps;  // oldest first
  };

  explicit FollowLight(Hooks hooks, std::chrono::milliseconds between_looks = std::chrono::milliseconds(200));

  /// Begins what the destructor does, and does not wait for it.
  void ask_to_stop() { thread_.request_stop(); }

  /// Of a camera that was looked at; the state is off for all others.
  Status status(int camera_id) const;
  /// Back to the accepted table, until following is switched off and on again; soon after, for other threads.
  /// When it returns, no adapted table is put any more.
  void take_back(int camera_id);

 private:
  struct Followed {
    explicit Followed(std::shared_ptr<const Lut> accepted) : follower(std::move(accepted)) {}
    LightFollower follower;
    std::uint64_t version = 0;  // of the frame that was looked at last
    /// The newest, kept until cameras have surely let go of them: to free megabytes costs a frame's time.
    std::deque<std::shared_ptr<const Lut>> tables;
  };
  void serve(const std::stop_token& ending);
  void look_at(const Camera& camera, Followed& followed, bool take_back);
  bool is_to_be_taken_back(int camera_id) const;

  const Hooks hooks_;
  const std::chrono::milliseconds between_looks_;
  std::map<int, Followed> followed_;  // by camera id; its own thread's
  std::mutex putting_;                // while a table is put; taken before mutex_
  mutable std::mutex mutex_;          // guards what follows
  std::condition_variable_any ordered_;
  std::set<int> to_take_back_;
  std::map<int, Status> statuses_;
  std::jthread thread_;  // last: it uses all the others
};

}  // namespace sslv
