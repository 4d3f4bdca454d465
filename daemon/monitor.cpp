// SPDX-License-Identifier: Apache-2.0
#include "monitor.h"

#include "base/background.h"
#include "base/clock.h"

#include <chrono>
#include <condition_variable>
#include <stop_token>
#include <utility>

namespace sslv {

Monitor::Monitor(const std::filesystem::path& state_folder, std::function<Cameras()> cameras,
                 std::function<void()> then)
    : cameras_(std::move(cameras)), then_(std::move(then)), computer_reader_(state_folder) {
  computer_ = computer_reader_.read();
  clock_ = read_clock();
  thread_ = std::jthread([this](const std::stop_token& stop) {
    become_background_thread("monitor");
    std::mutex idle;
    std::condition_variable_any alarm;
    std::unique_lock lock(idle);
    auto next = std::chrono::steady_clock::now();
    for (;;) {
      // At even intervals; seconds that were slept through are left out.
      next = std::max(next + std::chrono::seconds(1), std::chrono::steady_clock::now());
      alarm.wait_until(lock, stop, next, [&] { return stop.stop_requested(); });
      if (stop.stop_requested()) return;
      look();
      then_();
    }
  });
}

ComputerFigures Monitor::computer() const {
  const std::lock_guard lock(mutex_);
  return computer_;
}

std::optional<ClockFigures> Monitor::clock() const {
  const std::lock_guard lock(mutex_);
  return clock_;
}

std::optional<Exposure> Monitor::exposure(int camera_id) const {
  const std::lock_guard lock(mutex_);
  const auto found = exposures_.find(camera_id);
  return found == exposures_.end() ? std::nullopt : std::optional(found->second);
}

void Monitor::look() {
  const Cameras cameras = cameras_();
  std::map<int, Timeline::Reading> readings;
  std::map<int, Exposure> exposures;
  std::map<int, Seen> seen;
  for (const auto& camera : cameras) {
    const int id = camera->settings()->id;
    Seen before = seen_[id];
    if (before.camera.lock() != camera) before = {camera};
    readings[id] = read(*camera, before);
    // Held no longer than it is looked at: it is one of the few frames of the camera's ring.
    if (const auto newest = camera->pipeline().finished().peek();
        newest && newest->version > before.picture) {
      before.picture = newest->version;
      const auto mask = camera->pipeline().setup()->world.mask;
      if (const auto exposure = measure_exposure(newest->value->image.view(), *mask))
        exposures[id] = *exposure;
    }
    seen[id] = std::move(before);
  }
  seen_ = std::move(seen);
  timeline_.add(unix_time_s(), 1e-9 * static_cast<double>(steady_ns()), readings);
  ComputerFigures computer = computer_reader_.read();
  const auto clock = read_clock();
  const std::lock_guard lock(mutex_);
  computer_ = std::move(computer);
  clock_ = clock;
  exposures_ = std::move(exposures);
}

Timeline::Reading Monitor::read(const RunningCamera& camera, Seen& seen) const {
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
  // Counted before they are read: what comes in between is of the next second too, and none is missed.
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
