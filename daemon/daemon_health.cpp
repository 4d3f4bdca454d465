// SPDX-License-Identifier: Apache-2.0
// How the daemon is, as the panel and the service manager ask.
#include "base/clock.h"
#include "base/params_json.h"
#include "calibration_age.h"
#include "daemon.h"
#include "health/histogram.h"
#include "metrics.h"
#include "net/network_cards.h"
#include "status.h"
#include "vision/flood_cut.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

namespace sslv {
namespace {

/// What is asked of a camera. A player's speed is for its viewer to choose.
std::optional<double> wanted_fps(const Json& source) {
  const auto rate = source.find("frame_rate_hz");
  if (source.at("backend") == "files" || rate == source.end() || !rate->is_number()) return std::nullopt;
  const double fps = rate->get<double>();
  return fps > 0 ? std::optional(fps) : std::nullopt;
}

bool is_of_another_host(const std::vector<OtherVision>& visions) {
  if (visions.empty()) return false;
  std::set<std::string> ours;
  for (const NetworkCard& card : network_cards()) {
    for (const auto& address : card.addresses) ours.insert(address.to_string());
  }
  return std::any_of(visions.begin(), visions.end(),
                     [&](const OtherVision& other) { return !ours.contains(other.address); });
}

Json histogram_json(const RecentDurations& durations) {
  const Histogram histogram = make_histogram(durations.samples_ns());
  return {{"edges_us", histogram.edges_us}, {"counts", histogram.counts}};
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

Json computer_json(const ComputerFigures& computer) {
  const ComputerFigures::Process& process = computer.process;
  Json out{{"host", computer.host},
           {"kernel", computer.kernel},
           {"uptime_s", computer.uptime_s},
           {"load", computer.load},
           {"cpu_percent", computer.cpu_percent},
           {"memory",
            {{"total_bytes", computer.memory_bytes}, {"available_bytes", computer.memory_available_bytes}}},
           {"disk", nullptr},
           {"temperature_c", computer.temperature_c ? Json(*computer.temperature_c) : Json(nullptr)},
           {"process",
            {{"cpu_percent", process.cpu_percent},
             {"rss_bytes", process.rss_bytes},
             {"threads", process.threads},
             {"descriptors", process.descriptors}}}};
  if (const auto& disk = computer.disk) {
    out["disk"] = {{"folder", disk->folder.string()},
                   {"total_bytes", disk->total_bytes},
                   {"free_bytes", disk->free_bytes}};
  }
  return out;
}

Json clock_json(const std::optional<ClockFigures>& clock) {
  if (!clock) return nullptr;
  return {{"synchronised", clock->synchronised},
          {"offset_ms", clock->offset_ms},
          {"estimated_error_ms", clock->estimated_error_ms}};
}

std::vector<CameraNow> healths(const std::vector<std::shared_ptr<RunningCamera>>& cameras) {
  std::vector<CameraNow> out;
  for (const auto& camera : cameras) out.push_back({camera->settings()->id, camera->health()});
  return out;
}

}  // namespace

void Daemon::add_health_to(WebHost& host) {
  host.status = [this] { return status(); };
  host.timeline = [this](int seconds) {
    return monitor_.timeline().to_json(static_cast<std::size_t>(seconds));
  };
  host.diagnostics = [this] { return diagnostics(); };
  host.metrics = [this] { return metrics(); };
  host.hanging = [this] { return hanging(); };
  host.missing = [this] { return find_missing(healths(cameras_now()), multicast_.status()); };
}

std::vector<std::shared_ptr<RunningCamera>> Daemon::cameras_now() const {
  std::vector<std::shared_ptr<RunningCamera>> out;
  const auto cameras = cameras_.load();
  for (const auto& [id, camera] : *cameras) out.push_back(camera);
  return out;
}

std::string Daemon::summary() const {
  const auto config = config_.load();
  return status_line(health_input(*config, cameras_now()));
}

std::string Daemon::hanging() const {
  return find_hanging(healths(cameras_now()), steady_ns());
}

std::string Daemon::metrics() const {
  const WebServer* web = listening_;
  return metrics_text({.cameras = cameras_now(),
                       .network = multicast_.status(),
                       .clock = monitor_.clock(),
                       .viewers = web ? web->stats().viewers : 0,
                       .settings_since_s = settings_since_s_});
}

Json Daemon::status() {
  const WebServer* web = listening_;
  const auto config = config_.load();
  const auto cameras = cameras_now();
  StatusInput input{.time_s = unix_time_s(),
                    .uptime_s = steady_s() - started_s_,
                    .health = health_input(*config, cameras),
                    .alerts = {},
                    .refused_packets = other_visions_.refused(),
                    .settings_revision = store_.revision(),
                    .viewers = web ? web->stats().viewers : 0,
                    .cameras = cameras};
  input.alerts = find_alerts(input.health);
  alert_times_.stamp(input.alerts, input.time_s, steady_s());
  return status_json(input);
}

HealthInput Daemon::health_input(const Config& config,
                                 const std::vector<std::shared_ptr<RunningCamera>>& cameras) const {
  HealthInput input{.config = config,
                    .network = multicast_.status(),
                    .geometry = geometry_.load(),
                    .other_visions = other_visions_.seen(steady_s()),
                    .listening_error = other_visions_.error(),
                    .referee = referee_.status(steady_s()),
                    .settings_problem = store_.problem(),
                    .save_problem = state_folder_.write_problem(),
                    .state_problem = state_folder_.find_problem(),
                    .reload_problem = store_.reload_problem(),
                    .lost_tables = {},
                    .computer = monitor_.computer(),
                    .clock = monitor_.clock(),
                    .cameras = {}};
  input.another_host_sends = is_of_another_host(input.other_visions);
  const auto lost = lost_tables_.load();
  for (const CameraSettings& camera : config.cameras) {
    if (const auto found = lost->find(camera.colors.table); found != lost->end())
      input.lost_tables.push_back(found->second);
  }
  const auto stale = stale_calibrations_.load();
  for (const auto& camera : cameras) {
    const auto settings = camera->settings();
    const int id = settings->id;
    const auto place = std::find_if(config.cameras.begin(), config.cameras.end(),
                                    [&](const CameraSettings& one) { return one.id == id; });
    const auto setup = camera->pipeline().setup();
    const auto scene = setup->world.scene;
    const auto last_minute = monitor_.timeline().sum(id, 60);
    const auto counters = camera->pipeline().counters();
    const bool is_flooded = counters.flood.blocks > 0 && counters.frames_since_flood <= last_minute.frames;
    input.cameras.push_back(
        {.id = id,
         .place = static_cast<std::size_t>(place - config.cameras.begin()),
         .backend = settings->source.at("backend"),
         .wanted_fps = wanted_fps(settings->source),
         .health = camera->health(),
         .calibration = scene->camera ? std::optional(scene->camera->calibration()) : std::nullopt,
         .field_changed_since_calibrated = stale->contains(id),
         .latency_p99_ms = camera->latency().percentiles().p99_us * 1e-3,
         .last_minute = last_minute,
         .last_seconds = monitor_.timeline().sum(id, CameraFacts::kLastSeconds),
         .exposure = monitor_.exposure(id),
         .least_margin = least_margin(id, *setup->world.labels),
         .flood = is_flooded ? flood_text(counters.flood, setup->world.labels->name(counters.flood.label))
                             : std::string()});
  }
  return input;
}

std::optional<CameraFacts::Margin> Daemon::least_margin(int camera_id, const LabelSet& labels) const {
  const auto margins = color_margins_.newest_margins(camera_id);
  if (!margins) return {};
  const auto least = least_of(*margins);
  if (!least) return CameraFacts::Margin{CameraFacts::Margin::kMost, ""};
  return CameraFacts::Margin{std::abs(least->change),
                             margin_text(name_of(least->surface), labels.name(least->label), least->change)};
}

Json Daemon::diagnostics() const {
  const WebServer* web = listening_;
  const WebStats stats = web ? web->stats() : WebStats{};
  Json out{{"system", computer_json(monitor_.computer())},
           {"clock", clock_json(monitor_.clock())},
           {"web",
            {{"connections", stats.connections},
             {"viewers", stats.viewers},
             {"jpegs_encoded", stats.jpegs_encoded}}},
           {"cameras", Json::array()}};
  for (const auto& camera : cameras_now())
    out["cameras"].push_back(camera_diagnostics_json(*camera, monitor_.exposure(camera->settings()->id)));
  return out;
}

void Daemon::look_after() {
  stills_.forget_old();
  move_panel_if_needed();
  find_stale_calibrations();
  // So that a break of an alert is seen while nobody asks.
  const auto config = config_.load();
  auto alerts = find_alerts(health_input(*config, cameras_now()));
  alert_times_.stamp(alerts, unix_time_s(), steady_s());
}

void Daemon::find_stale_calibrations() {
  const auto config = config_.load();
  if (config == calibrations_looked_at_) return;
  calibrations_looked_at_ = config;
  std::set<int> stale;
  const std::lock_guard lock(calibration_mutex_);
  const Json settings = store_.current().settings, steps = store_.history();
  for (const Json& camera : settings.at("cameras")) {
    const int id = camera.at("id").get<int>();
    CalibrationHistory::Records records = calibration_history_.of(id);
    const CalibrationRecord* newest = newest_in_force(records);
    // Of one that was set in another way it is not known for which field it was made.
    if (newest == nullptr || camera.at("calibration") != params_to_json(newest->calibration)) continue;
    if (field_changed_since(newest->time_s, settings, steps)) stale.insert(id);
  }
  stale_calibrations_.store(std::move(stale));
}

}  // namespace sslv
