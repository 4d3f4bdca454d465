// SPDX-License-Identifier: Apache-2.0
#include "status.h"

#include "base/params_json.h"
#include "version.h"

#include <algorithm>

#include <fmt/format.h>

namespace sslv {
namespace {

Json calibration_json(const CameraModel& model) {
  Json out = params_to_json(model.calibration());
  out["derived_camera_world_tx"] = model.position_mm().x();
  out["derived_camera_world_ty"] = model.position_mm().y();
  out["derived_camera_world_tz"] = model.position_mm().z();
  return out;
}

Json camera_json(const RunningCamera& camera, const CameraHealth& health) {
  const auto settings = camera.settings();
  const auto setup = camera.pipeline().setup();
  const auto counters = camera.pipeline().counters();
  // What a camera that is not running last saw and how fast is no news.
  const bool running = health.state == CameraState::kRunning;
  const auto latency = running ? camera.latency() : RecentDurations::Percentiles{};
  Json out{{"id", settings->id},
           {"name", settings->name},
           {"backend", settings->source.at("backend")},
           {"state", name_of(health.state)},
           {"error", health.error},
           {"width", health.width},
           {"height", health.height},
           {"pixel_format", name_of(health.format)},
           {"fps", health.fps},
           {"frames", counters.frames},
           {"frames_dropped", health.dropped},
           {"frames_incomplete", health.incomplete},
           {"frames_capped", counters.capped},
           {"reconnects", health.reconnects},
           {"latency_ms", {{"p50", latency.p50_us * 1e-3}, {"p99", latency.p99_us * 1e-3}}},
           {"stages", Json::array()},
           {"robots", running ? counters.robots : 0},
           {"balls", running ? counters.balls : 0}};
  const auto& stack = setup->pipeline->stack();
  for (std::size_t i = 0; i < stack.size(); ++i) {
    const auto times = setup->pipeline->durations(i).percentiles();
    out["stages"].push_back({{"name", stack[i]}, {"p50_us", times.p50_us}, {"p99_us", times.p99_us}});
  }
  const auto& model = setup->world.scene->camera;
  out["calibration"] = model ? calibration_json(*model) : Json(nullptr);
  return out;
}

void add_alert(Json& alerts, const char* severity, std::string title, std::string fix,
               const Json& camera = nullptr) {
  alerts.push_back(
      {{"severity", severity}, {"title", std::move(title)}, {"fix", std::move(fix)}, {"camera", camera}});
}

/// What is wrong, worst first, each with what to do about it.
Json alerts_json(const StatusInput& input) {
  Json alerts = Json::array();
  for (const auto& [camera, health] : input.cameras) {
    if (health.state == CameraState::kLost) {
      add_alert(alerts, "bad", fmt::format("Camera {} is lost: {}", camera->settings()->id, health.error),
                camera->settings()->source.at("backend") == "files"
                    ? "Check source/path in its settings; it is tried again by itself."
                    : "Check its cable and power; it is tried again by itself.",
                camera->settings()->id);
    }
  }
  if (!input.network.error.empty()) {
    add_alert(alerts, "bad", "No packets leave", input.network.error + "; sending is tried again by itself.");
  }
  if (!input.settings_problem.empty()) {
    add_alert(alerts, "warn", input.settings_problem,
              "Look through the settings and save what is missing again.");
  }
  for (const auto& [camera, health] : input.cameras) {
    const int id = camera->settings()->id;
    const auto& model = camera->pipeline().setup()->world.scene->camera;
    if (!model) {
      add_alert(alerts, "warn", fmt::format("Camera {} is not calibrated", id),
                "Nothing it sees can be located: set its calibration.", id);
    } else if (health.width > 0 && (health.width != model->calibration().pixel_image_width ||
                                    health.height != model->calibration().pixel_image_height)) {
      add_alert(alerts, "bad",
                fmt::format("Camera {} sends {}x{} pixels, its calibration was made for {}x{}", id,
                            health.width, health.height, model->calibration().pixel_image_width,
                            model->calibration().pixel_image_height),
                "All positions are wrong: set the old picture size, or calibrate again.", id);
    }
    if (camera->pipeline().counters().capped > 0) {
      add_alert(alerts, "warn",
                fmt::format("Camera {} had {} frames with too much to look at", id,
                            camera->pipeline().counters().capped),
                "Its colour table labels too much of the picture: narrow the colours, or mask what is not field.", id);
    }
  }
  return alerts;
}

}  // namespace

Json status_json(const StatusInput& input) {
  const MulticastSettings& vision = input.config.network.vision;
  Json out{{"version", kVersion},
           {"site", input.config.site},
           {"time", input.time_s},
           {"uptime_s", input.time_s - input.started_s},
           {"field", params_to_json(input.config.field)},
           {"network",
            {{"group", vision.group},
             {"port", vision.port},
             {"interface", vision.interface},
             {"error", input.network.error},
             {"packets_sent", input.network.packets_sent},
             {"send_errors", input.network.send_errors},
             {"packets_per_s", input.network.packets_per_s}}},
           {"viewers", input.viewers},
           {"alerts", alerts_json(input)},
           {"cameras", Json::array()}};
  for (const auto& [camera, health] : input.cameras) out["cameras"].push_back(camera_json(*camera, health));
  return out;
}

std::string status_line(const StatusInput& input) {
  std::size_t running = 0;
  double fps = 0, p99_us = 0;
  for (const auto& [camera, health] : input.cameras) {
    if (health.state != CameraState::kRunning) continue;
    fps = running == 0 ? health.fps : std::min(fps, health.fps);
    p99_us = std::max(p99_us, camera->latency().p99_us);
    ++running;
  }
  return fmt::format("{}/{} cameras {:.1f} fps p99 {:.1f} ms -> {}:{}{}", running, input.cameras.size(), fps,
                     p99_us * 1e-3, input.config.network.vision.group, input.config.network.vision.port,
                     input.network.error.empty() ? "" : " (not sending)");
}

}  // namespace sslv
