// SPDX-License-Identifier: Apache-2.0
#include "services/cameras/camera_service.h"

#include "base/clock.h"
#include "base/log.h"
#include "services/cameras/camera_json.h"
#include "services/cameras/camera_routes.h"
#include "vision/flood_cut.h"

#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

/// Returns the requested frame rate; nothing for a recording, whose speed the user chooses.
std::optional<double> wanted_fps(const Json& source) {
  const auto rate = source.find("frame_rate_hz");
  if (source.at("backend") == "files" || rate == source.end() || !rate->is_number()) return std::nullopt;
  const double fps = rate->get<double>();
  return fps > 0 ? std::optional(fps) : std::nullopt;
}

/// Adds the stages' current notes to `stages`.
std::vector<StageFigures> stages_of(const RunningCamera& camera, std::vector<StageFigures> stages) {
  const auto setup = camera.pipeline().setup();
  for (std::size_t i = 0; i < std::min(stages.size(), setup->pipeline->stack().size()); ++i)
    stages[i].note = setup->pipeline->note(i);
  return stages;
}

}  // namespace

void CameraService::each_second() {
  cameras_.drop_stopped();
  const List cameras = cameras_.list();
  watch_.look(cameras);
  tell_what_became(cameras);
}

void CameraService::tell_what_became(const List& cameras) {
  std::map<int, Told> told;
  for (const auto& camera : cameras) {
    const int id = camera->settings()->id;
    Told now = told_[id];
    const auto has_grown = [](std::optional<std::uint64_t>& count, std::uint64_t newest) {
      const auto before = std::exchange(count, newest);
      return before && newest > *before;
    };
    if (has_grown(now.reconnects, camera->health().reconnects))
      events_.add({"camera_reopened", fmt::format("Camera {} was reopened after a loss", id), "", id});
    if (has_grown(now.reopenings, camera->reopenings()))
      events_.add({"camera_reopened", fmt::format("Camera {} was reopened with other settings", id), "", id});
    if (const auto line = now.losses.look(watch_.timeline().sum(id, 1), steady_s())) {
      line->is_end ? log::info("camera {}: {}", id, line->text)
                   : log::warning("camera {}: {}", id, line->text);
    }
    told[id] = now;
  }
  told_ = std::move(told);
}

std::vector<CameraFacts> CameraService::facts_of(const List& cameras) const {
  std::vector<CameraFacts> out;
  for (const auto& camera : cameras) {
    const auto settings = camera->settings();
    const int id = settings->id;
    const CameraProgress progress = camera->progress();
    const auto last_minute = watch_.timeline().sum(id, 60);
    const auto counters = camera->pipeline().counters();
    // Sums only whole seconds since the last reopening: before that, another camera with another requested
    // rate may have used this id.
    const auto newest = [&](std::size_t seconds) {
      const auto whole_s = static_cast<std::size_t>(steady_s() - camera->reopened_s());
      return watch_.timeline().sum(id, std::min(seconds, std::max<std::size_t>(whole_s, 1) - 1));
    };
    const bool is_flooded = counters.flood.blocks > 0 && counters.frames_since_flood <= last_minute.frames;
    const auto labels = camera->pipeline().setup()->context.labels;
    out.push_back(
        {.id = id,
         .backend = settings->source.at("backend"),
         .wanted_fps = wanted_fps(settings->source),
         .health = progress.health,
         .latency_p99_ms = camera->latency().percentiles().p99_us * 1e-3,
         .latency_images = camera->latency().count(),
         .last_minute = last_minute,
         .last_seconds = newest(CameraFacts::kLastSeconds),
         .newest_seconds = newest(CameraFacts::kNewestSeconds),
         .exposure = watch_.exposure(id),
         .controls_unsaved = camera->unsaved_controls().size(),
         .sends = std::ranges::find(settings->running.stages, "publish") != settings->running.stages.end(),
         .origin = origin_of(settings->source),
         .running = settings->running,
         .stages = stages_of(*camera, watch_.stages(id)),
         .hang = find_hang(progress, steady_ns()),
         .flood =
             is_flooded ? flood_text(counters.flood, labels->name(counters.flood.label)) : std::string()});
  }
  return out;
}

void CameraService::report(HealthReport& report) const {
  const List cameras = cameras_.list();
  const std::vector<CameraFacts> facts = facts_of(cameras);
  report_cameras(facts, report);
  report_left_out(left_out_libraries(), report);
  if (!report.status) return;
  Json& figures = (*report.status)["cameras"] = Json::array();
  for (std::size_t i = 0; i < cameras.size(); ++i)
    figures.push_back(camera_json(*cameras[i], facts[i].health, facts[i].hang));
}

std::string CameraService::summary() const {
  return camera_summary(facts_of(cameras_.list()));
}

void CameraService::add_diagnostics(Json& diagnostics) const {
  diagnostics["cameras"] = Json::array();
  for (const auto& camera : cameras_.list())
    diagnostics["cameras"].push_back(
        camera_diagnostics_json(*camera, watch_.exposure(camera->settings()->id)));
}

void CameraService::write_metrics(MetricsText& out) const {
  write_camera_metrics(out, cameras_.list());
}

std::vector<SupportFile> CameraService::support_files() const {
  std::vector<SupportFile> files{{"timeline.json", "the last ten minutes, second by second",
                                  [this] { return json_text(watch_.timeline().to_json(600), 2) + "\n"; }}};
  for (const auto& camera : cameras_.list()) {
    const int id = camera->settings()->id;
    files.push_back({fmt::format("camera_{}/picture.jpg", id), "its newest image, in full size",
                     [camera] { return full_jpeg(*camera); }});
  }
  return files;
}

std::vector<Route> CameraService::routes() {
  return camera_routes({.views = cameras_,
                        .timeline = watch_.timeline(),
                        .find = [this](int id) { return cameras_.find(id); },
                        .events = events_});
}

}  // namespace sslv
