// SPDX-License-Identifier: Apache-2.0
#include "services/cameras/camera_watch.h"

#include "base/clock.h"

#include <utility>

namespace sslv {

std::optional<Exposure> CameraWatch::exposure(int camera_id) const {
  const std::lock_guard lock(mutex_);
  const auto found = exposures_.find(camera_id);
  return found == exposures_.end() ? std::nullopt : std::optional(found->second);
}

std::vector<StageFigures> CameraWatch::stages(int camera_id) const {
  const std::lock_guard lock(mutex_);
  const auto found = stages_.find(camera_id);
  return found == stages_.end() ? std::vector<StageFigures>{} : found->second;
}

void CameraWatch::look(const std::vector<std::shared_ptr<RunningCamera>>& cameras) {
  std::map<int, Timeline::Reading> readings;
  std::map<int, Exposure> exposures;
  std::map<int, std::vector<StageFigures>> stages;
  std::map<int, Seen> seen;
  for (const auto& camera : cameras) {
    const int id = camera->settings()->id;
    Seen before = std::move(seen_[id]);
    if (before.camera.lock() != camera) {
      before = {camera};
      timeline_.forget(id);
    }
    readings[id] = read(*camera, before);
    before.stages.look(camera->pipeline().setup()->pipeline);
    stages[id] = before.stages.figures();
    // Hold the frame only while it is measured: the camera's ring buffer has only a few frames.
    if (const auto newest = camera->pipeline().finished().peek(); newest && newest->version > before.frame) {
      before.frame = newest->version;
      const auto mask = camera->pipeline().setup()->context.mask;
      if (const auto exposure = measure_exposure(newest->value->image.view(), *mask))
        exposures[id] = *exposure;
    }
    seen[id] = std::move(before);
  }
  seen_ = std::move(seen);
  timeline_.add(unix_time_s(), 1e-9 * static_cast<double>(steady_ns()), readings);
  const std::lock_guard lock(mutex_);
  exposures_ = std::move(exposures);
  stages_ = std::move(stages);
}

Timeline::Reading CameraWatch::read(const RunningCamera& camera, Seen& seen) {
  const CameraHealth health = camera.health();
  const auto counters = camera.pipeline().counters();
  Timeline::Reading out{.is_running = health.state == CameraState::kRunning,
                        .fps = health.fps,
                        .times = {},
                        .robots = counters.robots,
                        .balls = counters.balls,
                        .frames = counters.frames,
                        .dropped = health.dropped,
                        .incomplete = health.incomplete,
                        .capped = counters.capped};
  // Read the counts before the samples: an image that finishes in between is counted again in the next
  // second, but none is missed.
  const std::uint64_t latencies = camera.latency().count(), ages = camera.age().count();
  if (latencies > seen.latencies && ages > seen.ages) {
    const auto latency = camera.latency().percentiles(seen.latencies);
    out.times = {latency.p50_us * 1e-3, latency.p99_us * 1e-3,
                 camera.age().percentiles(seen.ages).p99_us * 1e-3};
  }
  seen.latencies = latencies;
  seen.ages = ages;
  return out;
}

}  // namespace sslv
