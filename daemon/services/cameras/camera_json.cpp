// SPDX-License-Identifier: Apache-2.0
#include "services/cameras/camera_json.h"

#include "base/clock.h"
#include "base/params_json.h"
#include "config/stages.h"
#include "health/histogram.h"
#include "services/cameras/camera_report.h"

#include <algorithm>
#include <atomic>
#include <string>
#include <utility>

namespace sslv {
namespace {

Json calibration_json(const CameraModel& model) {
  Json out = params_to_json(model.calibration());
  out["derived_camera_world_tx"] = model.position_mm().x();
  out["derived_camera_world_ty"] = model.position_mm().y();
  out["derived_camera_world_tz"] = model.position_mm().z();
  return out;
}

const char* t_capture_from(const CaptureTimes& times) {
  if (!times.t_capture_sigma_s) return "arrival";
  return times.is_by_ptp ? "ptp" : "camera";
}

Json histogram_json(const RecentDurations& durations) {
  const Histogram histogram = make_histogram(durations.samples_ns());
  return {{"edges_us", histogram.edges_us}, {"counts", histogram.counts}};
}

std::uint64_t read(const std::atomic<std::uint64_t>& counter) {
  return counter.load(std::memory_order_relaxed);
}

/// Whether the stage was ever in the camera's stack; other stages get no metrics.
bool has_run(const DurationTotals::Reading& durations) {
  return durations.counts != decltype(durations.counts){};
}

struct Reading {
  std::string id;
  CameraHealth health;
  const CameraTotals& totals;
};

}  // namespace

Json camera_json(const RunningCamera& camera, const CameraHealth& health, const std::optional<Hang>& hang) {
  const auto settings = camera.settings();
  const auto setup = camera.pipeline().setup();
  const auto counters = camera.pipeline().counters();
  // Measurements of a camera that is no longer running are out of date.
  const bool running = health.state == CameraState::kRunning;
  const auto latency = running ? camera.latency().percentiles() : RecentDurations::Percentiles{};
  const auto age = running ? camera.age().percentiles() : RecentDurations::Percentiles{};
  Json out{{"id", settings->id},
           {"name", settings->name},
           {"backend", settings->source.at("backend")},
           {"origin", name_of(origin_of(settings->source))},
           {"state", name_of(health.state)},
           {"error", health.error},
           {"width", health.width},
           {"height", health.height},
           {"pixel_format", health.width > 0 ? Json(name_of(health.format)) : Json(nullptr)},
           {"fps", health.fps},
           {"frames", counters.frames},
           {"frames_dropped", health.dropped},
           {"frames_incomplete", health.incomplete},
           {"frames_capped", counters.capped},
           {"packets", health.packets
                           ? Json{{"missing", health.packets->missing}, {"resent", health.packets->resent}}
                           : Json(nullptr)},
           {"reconnects", health.reconnects},
           {"controls_unsaved", camera.unsaved_controls().size()},
           {"latency_ms", {{"p50", latency.p50_us * 1e-3}, {"p99", latency.p99_us * 1e-3}}},
           {"age_ms", {{"p50", age.p50_us * 1e-3}, {"p99", age.p99_us * 1e-3}}},
           {"t_capture_from", t_capture_from(health.times)},
           {"t_capture_sigma_ms",
            health.times.t_capture_sigma_s ? Json(*health.times.t_capture_sigma_s * 1e3) : Json(nullptr)},
           {"stages", stages_json(*setup->pipeline)},
           {"hangs", to_json(hang, unix_time_s(), steady_ns())},
           {"robots", running ? counters.robots : 0},
           {"balls", running ? counters.balls : 0}};
  const auto& model = setup->context.scene->camera;
  out["calibration"] = model ? calibration_json(*model) : Json(nullptr);
  return out;
}

Json camera_json(const RunningCamera& camera) {
  const CameraProgress progress = camera.progress();
  return camera_json(camera, progress.health, find_hang(progress, steady_ns()));
}

Json camera_diagnostics_json(const RunningCamera& camera, const std::optional<Exposure>& exposure) {
  Json out{{"id", camera.settings()->id},
           {"exposure", nullptr},
           {"latency", histogram_json(camera.latency())},
           {"age", histogram_json(camera.age())},
           {"stages", Json::array()}};
  if (exposure) {
    out["exposure"] = {{"clipped_share", exposure->clipped_share},
                       {"dark_share", exposure->dark_share},
                       {"mean_luma", exposure->mean_luma}};
  }
  const auto setup = camera.pipeline().setup();
  const auto& stack = setup->pipeline->stack();
  for (std::size_t i = 0; i < stack.size(); ++i)
    out["stages"].push_back(
        {{"name", stack[i]}, {"histogram", histogram_json(setup->pipeline->durations(i))}});
  return out;
}

Json control_json(const Control& control, const Json& saved, const std::vector<UnsavedControl>& unsaved) {
  Json out = control_json(control);
  const auto kept = saved.find(control.name);
  out["saved_value"] = kept == saved.end() ? Json(nullptr) : *kept;
  const auto found =
      std::ranges::find(unsaved, control.name, [](const auto& one) { return one.control.name; });
  out["unsaved"] = found != unsaved.end();
  out["revert_to"] = found == unsaved.end() ? Json(nullptr) : found->before;
  return out;
}

Json field_view_json(const FieldView* view) {
  Json hidden = Json::array();
  if (view) {
    for (const PixelRectangle& one : hidden_by(*view))
      hidden.push_back({one.left_px, one.top_px, one.width_px, one.height_px});
  }
  return {{"hidden", std::move(hidden)}};
}

void write_camera_metrics(MetricsText& out, const std::vector<std::shared_ptr<RunningCamera>>& running) {
  std::vector<Reading> cameras;
  for (const auto& camera : running)
    cameras.push_back({std::to_string(camera->settings()->id), camera->health(), camera->totals()});

  out.begin("sslv_camera_up", "gauge", "1 while the camera is open and runs.");
  for (const auto& [id, health, totals] : cameras)
    out.add({{"camera", id}}, std::uint64_t{health.state == CameraState::kRunning});

  out.begin("sslv_frames_captured_total", "counter", "Images that were processed.");
  for (const auto& [id, health, totals] : cameras) out.add({{"camera", id}}, read(totals.frames));

  out.begin("sslv_frames_dropped_total", "counter",
            "Images that arrived damaged, or were not processed in time.");
  for (const auto& [id, health, totals] : cameras) {
    out.add({{"camera", id}, {"reason", "not_processed"}}, read(totals.capture.dropped));
    out.add({{"camera", id}, {"reason", "damaged"}}, read(totals.capture.incomplete));
  }

  out.begin("sslv_camera_reconnects_total", "counter", "Times the camera was reopened after a loss.");
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
      if (!has_run(durations)) continue;
      out.add({{"camera", id}, {"stage", stage_table()[i].name}}, durations);
    }
  }

  out.begin("sslv_senseless_total", "counter", "Invalid results of a stage that were dropped.");
  for (const auto& [id, health, totals] : cameras) {
    for (std::size_t i = 0; i < totals.left_out.size(); ++i) {
      if (!has_run(totals.stages[i].read())) continue;
      const std::string& stage = stage_table()[i].name;
      const InvalidCounts left_out = totals.left_out[i].read();
      out.add({{"camera", id}, {"stage", stage}, {"what", "robot"}}, left_out.robots);
      out.add({{"camera", id}, {"stage", stage}, {"what", "ball"}}, left_out.balls);
      out.add({{"camera", id}, {"stage", stage}, {"what", "time"}}, left_out.others);
    }
  }

  out.begin("sslv_capture_to_send_seconds", "histogram",
            "From the middle of an image's exposure to the sending of its packet.");
  for (const auto& [id, health, totals] : cameras) out.add({{"camera", id}}, totals.capture_to_send.read());
}

}  // namespace sslv
