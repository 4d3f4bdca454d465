// SPDX-License-Identifier: Apache-2.0
#include "services/colors/follow_light.h"

#include "base/background.h"
#include "capture/source.h"

#include <utility>

namespace sslv {

FollowLight::FollowLight(Hooks hooks, std::chrono::milliseconds between_looks)
    : hooks_(std::move(hooks)), between_looks_(between_looks), thread_([this](const std::stop_token& ending) {
        become_background_thread("light");
        serve(ending);
      }) {}

FollowLight::Status FollowLight::status(int camera_id) const {
  const std::lock_guard lock(mutex_);
  const auto found = statuses_.find(camera_id);
  return found == statuses_.end() ? Status{} : found->second;
}

void FollowLight::take_back(int camera_id) {
  {
    const std::scoped_lock lock(putting_, mutex_);
    to_take_back_.insert(camera_id);
  }
  ordered_.notify_one();
}

void FollowLight::serve(const std::stop_token& ending) {
  while (!ending.stop_requested()) {
    std::set<int> take_back;
    {
      std::unique_lock lock(mutex_);
      ordered_.wait_for(lock, ending, between_looks_, [&] { return !to_take_back_.empty(); });
      take_back = std::exchange(to_take_back_, {});
    }
    std::map<int, Followed> still;
    for (const Camera& camera : hooks_.cameras()) {
      if (ending.stop_requested()) return;
      auto node = followed_.extract(camera.id);
      const bool is_known = !node.empty() && node.mapped().follower.accepted() == camera.accepted;
      if (!is_known && !camera.params.enabled) continue;
      if (is_known) {
        still.insert(std::move(node));
      } else {
        still.emplace(camera.id, camera.accepted);
      }
      look_at(camera, still.at(camera.id), take_back.contains(camera.id));
    }
    followed_ = std::move(still);

    const std::lock_guard lock(mutex_);
    statuses_.clear();
    for (const auto& [id, followed] : followed_)
      statuses_[id] = {followed.follower.state(), followed.follower.steps()};
  }
}

void FollowLight::look_at(const Camera& camera, Followed& followed, bool take_back) {
  LightFollower& follower = followed.follower;
  if (take_back) follower.take_back();
  if (!camera.params.enabled) {
    follower.switch_off();
  } else {
    try {
      const auto frame = hooks_.wait_frame(camera.id, followed.version, std::chrono::milliseconds(0));
      if (frame) {
        followed.version = frame->version;
        follower.observe(camera.params, {frame->t_capture_s, frame->image, *camera.scene, *camera.patterns,
                                         frame->robots, hooks_.game_is_running()});
      }
    } catch (const CaptureError&) {  // the camera no longer exists; the next list lacks it
    }
  }
  if (auto table = follower.new_table()) {
    constexpr std::size_t kKept = 4;
    followed.tables.push_back(table);
    if (followed.tables.size() > kKept) followed.tables.pop_front();
    const std::lock_guard putting(putting_);
    if (!is_to_be_taken_back(camera.id)) hooks_.put_table(camera.id, camera.accepted, std::move(table));
  }
}

bool FollowLight::is_to_be_taken_back(int camera_id) const {
  const std::lock_guard lock(mutex_);
  return to_take_back_.contains(camera_id);
}

}  // namespace sslv
