// SPDX-License-Identifier: Apache-2.0
#include "status.h"

#include "base/params_json.h"
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
  const auto latency = running ? camera.latency() : RecentDurations::Percentiles{};
  const auto age = running ? camera.age() : RecentDurations::Percentiles{};
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

void add_alert(Json& alerts, const char* severity, std::string title, std::string fix,
               const Json& camera = nullptr) {
  alerts.push_back(
      {{"severity", severity}, {"title", std::move(title)}, {"fix", std::move(fix)}, {"camera", camera}});
}

int rank_of(const Json& alert) {
  const Json& severity = alert.at("severity");
  return severity == "bad" ? 0 : severity == "warn" ? 1 : 2;
}

std::string joined(const std::vector<std::string>& texts) {
  return fmt::format("{}", fmt::join(texts, ", "));
}

/// The sizes of the field that another vision tells otherwise.
std::vector<SizeConflict> field_conflicts(const StatusInput& input, const OtherVision& other) {
  if (!other.field) return {};
  SSL_WrapperPacket ours;
  write_geometry(*input.geometry, ours);
  return size_conflicts(ours.geometry().field(), *other.field);
}

/// What a second vision does to the teams, which cannot tell whose packets they get.
void add_vision_alerts(Json& alerts, const StatusInput& input) {
  for (const OtherVision& other : input.other_visions) {
    std::vector<std::string> shared_ids, conflicts;
    for (const CameraNow& now : input.cameras) {
      const auto id = static_cast<std::uint32_t>(now.camera->settings()->id);
      if (std::find(other.cameras.begin(), other.cameras.end(), id) != other.cameras.end()) {
        shared_ids.push_back(std::to_string(id));
      }
    }
    for (const SizeConflict& size : field_conflicts(input, other)) {
      conflicts.push_back(fmt::format("{} is {:g} here and {:g} there", size.name, size.ours, size.theirs));
    }
    if (!shared_ids.empty()) {
      add_alert(alerts, "bad",
                fmt::format("Camera id {} is also sent by {}", joined(shared_ids), other.address),
                "Teams mix up what the two cameras see: give each its own id, or end one of the visions.");
    }
    if (!conflicts.empty()) {
      add_alert(alerts, "bad", fmt::format("{} sends another field: {}", other.address, joined(conflicts)),
                "Teams get both in turn: set the same sizes, or end one of the visions.");
    }
    if (shared_ids.empty() && conflicts.empty()) {
      add_alert(alerts, "info", fmt::format("{} sends to the vision group too", other.address),
                "Nothing to do if it is the vision of this field's other cameras; otherwise end it.");
    }
  }
}

std::string game_controller_text(const GameController& one) {
  return one.source == one.address ? one.address : fmt::format("{} at {}", one.source, one.address);
}

/// What is wrong, worst first, each with what to do about it.
Json alerts_json(const StatusInput& input) {
  Json alerts = Json::array();
  for (const auto& [camera, health] : input.cameras) {
    for (const std::string& warning : health.warnings) {
      add_alert(
          alerts, "warn", fmt::format("Camera {} refused a control: {}", camera->settings()->id, warning),
          "Set it to what the camera takes, or remove it from source/controls.", camera->settings()->id);
    }
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
  add_vision_alerts(alerts, input);
  if (!input.settings_problem.empty()) {
    add_alert(alerts, "warn", input.settings_problem,
              "Look through the settings and save what is missing again.");
  }
  for (const auto& [camera, health] : input.cameras) {
    const int id = camera->settings()->id;
    const auto& model = camera->pipeline().setup()->world.scene->camera;
    if (!model) {
      add_alert(alerts, "warn", fmt::format("Camera {} is not calibrated", id),
                "Nothing it sees can be located: calibrate it.", id);
    } else if (health.width > 0 && (health.width != model->calibration().pixel_image_width ||
                                    health.height != model->calibration().pixel_image_height)) {
      add_alert(alerts, "bad",
                fmt::format("Camera {} sends {}x{} pixels, its calibration was made for {}x{}", id,
                            health.width, health.height, model->calibration().pixel_image_width,
                            model->calibration().pixel_image_height),
                "All positions are wrong: set the old picture size, or calibrate again.", id);
    }
    if (camera->pipeline().counters().capped > 0) {
      add_alert(
          alerts, "warn",
          fmt::format("Camera {} had {} frames with too much to look at", id,
                      camera->pipeline().counters().capped),
          "Its colour table labels too much of the picture: narrow the colours, or mask what is not field.",
          id);
    }
  }
  for (const TeamNow& team : teams_now(input.config.teams, input.referee.team_names)) {
    if (!team.name_is_unknown) continue;
    add_alert(alerts, "warn",
              fmt::format("Unknown team \"{}\": its robots are taken to be {:g} mm high", team.name,
                          team.robot_height_mm),
              "Measure the pattern's height and set robot_height in teams.");
  }
  if (const auto& other = input.referee.other) {
    add_alert(alerts, "warn",
              fmt::format("Two game controllers send: {}, which is followed, and {}",
                          game_controller_text(input.referee.followed), game_controller_text(*other)),
              "End the one that is not this field's, or set network/referee to this field's group and port.");
  }
  // While nothing can be sent either, its alert says what to do.
  if (input.network.error.empty()) {
    for (const std::string& error : {input.listening_error, input.referee.error}) {
      if (!error.empty())
        add_alert(alerts, "warn", "A group cannot be heard", error + "; it is tried again by itself.");
    }
  }
  std::stable_sort(alerts.begin(), alerts.end(),
                   [](const Json& a, const Json& b) { return rank_of(a) < rank_of(b); });
  return alerts;
}

Json teams_json(const StatusInput& input) {
  const auto teams = teams_now(input.config.teams, input.referee.team_names);
  const auto one = [&](Team which) {
    const TeamNow& team = teams[static_cast<std::size_t>(which)];
    return Json{{"name", team.name},
                {"robot_height", team.robot_height_mm},
                {"height_from", team.height_is_known ? "referee" : "settings"}};
  };
  return {{"yellow", one(Team::kYellow)}, {"blue", one(Team::kBlue)}};
}

Json other_visions_json(const StatusInput& input) {
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

Json referee_json(const StatusInput& input) {
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
             {"packets_per_s", input.network.packets_per_s},
             {"packets_refused", input.refused_packets},
             {"other_visions", other_visions_json(input)}}},
           {"referee", referee_json(input)},
           {"teams", teams_json(input)},
           {"settings_revision", input.settings_revision},
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
