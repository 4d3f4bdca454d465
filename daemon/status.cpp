// SPDX-License-Identifier: Apache-2.0
#include "status.h"

#include "base/params_json.h"
#include "checks.h"
#include "teams.h"
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

const char* t_capture_from(const CaptureTimes& times) {
  if (!times.t_capture_sigma_s) return "arrival";
  return times.is_by_ptp ? "ptp" : "camera";
}

Json camera_json(const RunningCamera& camera, const CameraHealth& health) {
  const auto settings = camera.settings();
  const auto setup = camera.pipeline().setup();
  const auto counters = camera.pipeline().counters();
  // What a camera that is not running last saw and how fast is no news.
  const bool running = health.state == CameraState::kRunning;
  const auto latency = running ? camera.latency().percentiles() : RecentDurations::Percentiles{};
  const auto age = running ? camera.age().percentiles() : RecentDurations::Percentiles{};
  Json out{{"id", settings->id},
           {"name", settings->name},
           {"backend", settings->source.at("backend")},
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
           {"latency_ms", {{"p50", latency.p50_us * 1e-3}, {"p99", latency.p99_us * 1e-3}}},
           {"age_ms", {{"p50", age.p50_us * 1e-3}, {"p99", age.p99_us * 1e-3}}},
           {"t_capture_from", t_capture_from(health.times)},
           {"t_capture_sigma_ms",
            health.times.t_capture_sigma_s ? Json(*health.times.t_capture_sigma_s * 1e3) : Json(nullptr)},
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

Json teams_json(const HealthInput& input) {
  const auto teams = teams_now(input.config.teams, input.referee.team_names);
  const auto one = [&](Team which) {
    const TeamNow& team = teams[static_cast<std::size_t>(which)];
    return Json{{"name", team.name},
                {"robot_height", team.robot_height_mm},
                {"height_from", team.height_is_known ? "referee" : "settings"}};
  };
  return {{"yellow", one(Team::kYellow)}, {"blue", one(Team::kBlue)}};
}

Json other_visions_json(const HealthInput& input) {
  Json out = Json::array();
  for (const OtherVision& other : input.other_visions) {
    Json conflicts = Json::array();
    for (const SizeConflict& size : field_conflicts(input, other)) {
      conflicts.push_back({{"name", size.name}, {"ours", size.ours}, {"theirs", size.theirs}});
    }
    out.push_back({{"address", other.address},
                   {"silent_s", other.silent_s},
                   {"cameras", other.cameras},
                   {"field_conflicts", std::move(conflicts)}});
  }
  return out;
}

Json game_controller_json(const GameController& one) {
  return {{"source", one.source}, {"address", one.address}};
}

Json referee_json(const HealthInput& input) {
  const RefereeSettings& settings = input.config.network.referee;
  const RefereeStatus& referee = input.referee;
  return {{"enabled", settings.enabled},
          {"group", settings.group},
          {"port", settings.port},
          {"error", referee.error},
          {"source", referee.followed.source},
          {"address", referee.followed.address},
          {"other", referee.other ? game_controller_json(*referee.other) : Json(nullptr)},
          {"silent_s", referee.silent_s ? Json(*referee.silent_s) : Json(nullptr)},
          {"game_is_running", referee.game_is_running},
          {"packets_refused", referee.refused}};
}

}  // namespace

Json status_json(const StatusInput& input) {
  const HealthInput& health = input.health;
  const MulticastSettings& vision = health.config.network.vision;
  const std::vector<Check> checks = make_checks(health, input.alerts);
  Json out{{"version", kVersion},
           {"site", health.config.site},
           {"time", input.time_s},
           {"uptime_s", input.uptime_s},
           {"field", params_to_json(health.config.field)},
           {"network",
            {{"group", vision.group},
             {"port", vision.port},
             {"interface", vision.interface},
             {"error", health.network.error},
             {"packets_sent", health.network.packets_sent},
             {"send_errors", health.network.send_errors},
             {"packets_per_s", health.network.packets_per_s},
             {"packets_refused", input.refused_packets},
             {"other_visions", other_visions_json(health)}}},
           {"referee", referee_json(health)},
           {"teams", teams_json(health)},
           {"settings_revision", input.settings_revision},
           {"viewers", input.viewers},
           {"alerts", Json::array()},
           {"go", is_go(checks)},
           {"checks", Json::array()},
           {"cameras", Json::array()}};
  for (const Alert& alert : input.alerts) out["alerts"].push_back(to_json(alert));
  for (const Check& check : checks) out["checks"].push_back(to_json(check));
  for (std::size_t i = 0; i < input.cameras.size(); ++i)
    out["cameras"].push_back(camera_json(*input.cameras[i], health.cameras[i].health));
  return out;
}

std::string status_line(const HealthInput& input) {
  std::size_t running = 0;
  double fps = 0, p99_ms = 0;
  for (const CameraFacts& camera : input.cameras) {
    if (camera.health.state != CameraState::kRunning) continue;
    fps = running == 0 ? camera.health.fps : std::min(fps, camera.health.fps);
    p99_ms = std::max(p99_ms, camera.latency_p99_ms);
    ++running;
  }
  return fmt::format("{}/{} cameras {:.1f} fps p99 {:.1f} ms -> {}:{}{}", running, input.cameras.size(), fps,
                     p99_ms, input.config.network.vision.group, input.config.network.vision.port,
                     input.network.error.empty() ? "" : " (not sending)");
}

}  // namespace sslv
