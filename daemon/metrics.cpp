// SPDX-License-Identifier: Apache-2.0
#include "metrics.h"

#include "health/metrics_text.h"
#include "stages.h"
#include "version.h"

#include <atomic>

#include <fmt/format.h>

namespace sslv {
namespace {

/// A turn of a camera's thread takes 0.1 s and a frame's processing.
constexpr std::int64_t kHangs_ns = 5'000'000'000;

struct Reading {
  std::string id;
  CameraHealth health;
  const CameraTotals& totals;
};

std::uint64_t read(const std::atomic<std::uint64_t>& counter) {
  return counter.load(std::memory_order_relaxed);
}

void write_cameras(MetricsText& out, const std::vector<Reading>& cameras) {
  out.begin("sslv_camera_up", "gauge", "1 while the camera is open and runs.");
  for (const auto& [id, health, totals] : cameras)
    out.add({{"camera", id}}, std::uint64_t{health.state == CameraState::kRunning});

  out.begin("sslv_frames_captured_total", "counter", "Pictures that were processed.");
  for (const auto& [id, health, totals] : cameras) out.add({{"camera", id}}, read(totals.frames));

  out.begin("sslv_frames_dropped_total", "counter",
            "Pictures that came but were not processed in time, or came damaged.");
  for (const auto& [id, health, totals] : cameras) {
    out.add({{"camera", id}, {"reason", "not_processed"}}, read(totals.capture.dropped));
    out.add({{"camera", id}, {"reason", "damaged"}}, read(totals.capture.incomplete));
  }

  out.begin("sslv_camera_reconnects_total", "counter", "Times the camera was opened again after a loss.");
  for (const auto& [id, health, totals] : cameras) out.add({{"camera", id}}, read(totals.capture.reconnects));

  out.begin("sslv_detections_total", "counter", "Robots and balls sent.");
  for (const auto& [id, health, totals] : cameras) {
    out.add({{"camera", id}, {"kind", "robot_yellow"}}, read(totals.robots_yellow));
    out.add({{"camera", id}, {"kind", "robot_blue"}}, read(totals.robots_blue));
    out.add({{"camera", id}, {"kind", "ball"}}, read(totals.balls));
  }

  out.begin("sslv_stage_duration_seconds", "histogram", "Time that a stage of the stack takes for a frame.");
  for (const auto& [id, health, totals] : cameras) {
    for (std::size_t i = 0; i < totals.stages.size(); ++i) {
      const auto durations = totals.stages[i].read();
      // A stage that was never in the camera's stack has no series.
      if (durations.counts == decltype(durations.counts){}) continue;
      out.add({{"camera", id}, {"stage", stage_table()[i].name}}, durations);
    }
  }

  out.begin("sslv_capture_to_send_seconds", "histogram",
            "From the middle of a picture's exposure to its packet's leaving.");
  for (const auto& [id, health, totals] : cameras) out.add({{"camera", id}}, totals.capture_to_send.read());
}

}  // namespace

std::string metrics_text(const MetricsInput& input) {
  std::vector<Reading> cameras;
  for (const auto& camera : input.cameras)
    cameras.push_back({std::to_string(camera->settings()->id), camera->health(), camera->totals()});

  MetricsText out;
  out.begin("sslv_build_info", "gauge", "Always 1; the label is the version.");
  out.add({{"version", kVersion}}, std::uint64_t{1});
  write_cameras(out, cameras);
  out.begin("sslv_packets_sent_total", "counter", "Packets sent to the vision group.");
  out.add({}, input.network.packets_sent);
  out.begin("sslv_send_errors_total", "counter", "Packets that did not leave.");
  out.add({}, input.network.send_errors);
  out.begin("sslv_preview_clients", "gauge", "Panels and other viewers connected by WebSocket.");
  out.add({}, static_cast<double>(input.viewers));
  if (input.clock) {
    out.begin("sslv_clock_offset_seconds", "gauge",
              "What the kernel still has to correct of the computer's clock.");
    out.add({}, input.clock->offset_ms * 1e-3);
    out.begin("sslv_clock_synchronized", "gauge", "1 while the kernel says that the clock is synchronised.");
    out.add({}, std::uint64_t{input.clock->synchronised});
  }
  out.begin("sslv_config_last_reload_success_timestamp_seconds", "gauge",
            "Unix time when the newest settings came into force.");
  out.add({}, input.settings_since_s);
  return out.take();
}

std::string find_hanging(const std::vector<CameraNow>& cameras, std::int64_t now_ns) {
  std::string out;
  for (const auto& [id, health] : cameras) {
    const std::int64_t still_ns = now_ns - health.progress_ns;
    if (health.state != CameraState::kRunning || still_ns < kHangs_ns) continue;
    out +=
        fmt::format("{}camera {} has hung for {} s", out.empty() ? "" : ", ", id, still_ns / 1'000'000'000);
  }
  return out;
}

std::string find_missing(const std::vector<CameraNow>& cameras, const MulticastStatus& network) {
  std::string out;
  for (const auto& [id, health] : cameras) {
    if (health.state == CameraState::kRunning) continue;
    out += fmt::format("camera {} is {}{}{}\n", id, name_of(health.state), health.error.empty() ? "" : ": ",
                       health.error);
  }
  if (!network.error.empty()) out += fmt::format("no packets leave: {}\n", network.error);
  return out;
}

}  // namespace sslv
