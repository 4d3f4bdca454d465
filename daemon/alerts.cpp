// SPDX-License-Identifier: Apache-2.0
#include "alerts.h"

#include "teams.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

// Of a minute's pictures. Trackers bridge a few; one in a thousand is a cable or a computer at its
// limit.
constexpr double kLostShare = 0.001;
constexpr std::uint64_t kFewPictures = 3;
// The painted lines are under 1 % of a field's picture, and they may clip: white has no colour to lose. More
// than twice that is glare or too much light, and clipped colours are taken for each other.
constexpr double kClippedShare = 0.02;
// Of 255. Below, the camera's noise is as large as what tells dark colours apart.
constexpr double kDarkLuma = 25;
constexpr double kSlowShare = 0.9;  // of the rate that was asked for
constexpr std::uint64_t kLittleDisk_bytes = 100'000'000;
constexpr double kLittleDiskShare = 0.02, kLittleMemoryShare = 0.05;

std::string joined(const std::vector<std::string>& texts) {
  return fmt::format("{}", fmt::join(texts, ", "));
}

std::string camera_page(const CameraFacts& camera) {
  return fmt::format("#/camera/{}", camera.id);
}

std::string calibration_page(const CameraFacts& camera) {
  return fmt::format("#/calibration/{}", camera.id);
}

void add_source_alerts(std::vector<Alert>& alerts, const CameraFacts& camera) {
  const CameraHealth& health = camera.health;
  for (const std::string& warning : health.warnings) {
    alerts.push_back({.id = "control_refused",
                      .check = CheckId::kCameras,
                      .severity = Severity::kWarn,
                      .title = fmt::format("Camera {} refused a control: {}", camera.id, warning),
                      .fix = "Set it to what the camera takes, or remove it from source/controls.",
                      .page = camera_page(camera),
                      .camera = camera.id,
                      .about = warning});
  }
  if (health.state == CameraState::kLost) {
    alerts.push_back({.id = "camera_lost",
                      .check = CheckId::kCameras,
                      .severity = Severity::kBad,
                      .title = fmt::format("Camera {} is lost: {}", camera.id, health.error),
                      .fix = camera.backend == "files"
                                 ? "Check source/path in its settings; it is tried again by itself."
                                 : "Check its cable and power; it is tried again by itself.",
                      .page = camera_page(camera),
                      .camera = camera.id});
  }
  // What the camera itself sends, whatever becomes of it here.
  const Timeline::Sum& sum = camera.last_seconds;
  if (camera.wanted_fps && sum.seconds >= CameraFacts::kLastSeconds &&
      static_cast<double>(sum.all()) < kSlowShare * *camera.wanted_fps * sum.seconds) {
    alerts.push_back(
        {.id = "camera_slow",
         .check = CheckId::kCameras,
         .severity = Severity::kWarn,
         .title = fmt::format("Camera {} sends {:.1f} pictures a second, {:g} are asked for", camera.id,
                              static_cast<double>(sum.all()) / sum.seconds, *camera.wanted_fps),
         .fix = "Shorten its exposure, make the picture smaller, or ask for a lower frame rate.",
         .page = camera_page(camera),
         .camera = camera.id});
  }
}

void add_picture_alerts(std::vector<Alert>& alerts, const CameraFacts& camera) {
  const auto warn = [&](const char* id, std::string title, std::string fix, std::string page) {
    alerts.push_back({.id = id,
                      .check = CheckId::kPictures,
                      .severity = Severity::kWarn,
                      .title = std::move(title),
                      .fix = std::move(fix),
                      .page = std::move(page),
                      .camera = camera.id});
  };
  const Timeline::Sum& minute = camera.last_minute;
  const auto is_much = [&](std::uint64_t count) {
    return count > kFewPictures &&
           static_cast<double>(count) > kLostShare * static_cast<double>(minute.all());
  };
  if (is_much(minute.dropped)) {
    warn("frames_dropped",
         fmt::format("Camera {}: {} of {} pictures of the last minute were not processed", camera.id,
                     minute.dropped, minute.all()),
         "This computer is too slow: end other programs, give the camera's thread a priority "
         "(thread/realtime_priority), or lower the frame rate.",
         "#/diagnostics");
  }
  if (is_much(minute.incomplete)) {
    warn("frames_incomplete",
         fmt::format("Camera {}: {} of {} pictures of the last minute came damaged", camera.id,
                     minute.incomplete, minute.all()),
         "Check cable and switch, and that the cameras together stay below the link's speed.",
         camera_page(camera));
  }
  if (minute.capped > 0) {
    const std::string what = camera.flood.empty() ? "too much to look at" : camera.flood;
    warn("frames_capped",
         fmt::format("Camera {}: {}, in {} of {} pictures of the last minute", camera.id, what, minute.capped,
                     minute.all()),
         camera.flood.empty() ? "Its colour table labels too much of the picture: narrow the colours, or "
                                "mask what is not field."
                              : "There nothing of that colour is seen. Learn the colours again, widen their "
                                "margins, or mask that "
                                "part if it is not field.",
         fmt::format("#/colors/{}", camera.id));
  }
  if (!camera.exposure) return;
  if (camera.exposure->clipped_share > kClippedShare) {
    warn("picture_clipped",
         fmt::format("Camera {}: {:.1f} % of the picture is too bright to have a colour", camera.id,
                     100 * camera.exposure->clipped_share),
         "Shorten its exposure, lower its gain or close its lens; mask lamps and windows beside the field.",
         camera_page(camera));
  }
  if (camera.exposure->mean_luma < kDarkLuma) {
    warn("picture_dark",
         fmt::format("Camera {}: the picture is dark, its mean luma is {:.0f} of 255", camera.id,
                     camera.exposure->mean_luma),
         "Turn on the light, open its lens, lengthen its exposure, or raise its gain.", camera_page(camera));
  }
}

void add_margin_alert(std::vector<Alert>& alerts, const CameraFacts& camera) {
  if (!camera.least_margin || camera.least_margin->share >= kWantedMargin) return;
  alerts.push_back(
      {.id = "margin_thin",
       .check = CheckId::kColors,
       .severity = camera.least_margin->share < kLeastMargin ? Severity::kBad : Severity::kWarn,
       .title = fmt::format("Camera {}: {}", camera.id, camera.least_margin->text),
       .fix =
           "A little more or less light drowns robots in it: widen the margins, or learn the colours again.",
       .page = fmt::format("#/colors/{}", camera.id),
       .camera = camera.id});
}

void add_calibration_alerts(std::vector<Alert>& alerts, const CameraFacts& camera) {
  const auto add = [&](const char* id, Severity severity, std::string title, std::string fix) {
    alerts.push_back({.id = id,
                      .check = CheckId::kCalibration,
                      .severity = severity,
                      .title = std::move(title),
                      .fix = std::move(fix),
                      .page = calibration_page(camera),
                      .camera = camera.id});
  };
  const CameraHealth& health = camera.health;
  const auto& made = camera.calibration;
  if (!made) {
    add("not_calibrated", Severity::kWarn, fmt::format("Camera {} is not calibrated", camera.id),
        "Nothing it sees can be located: calibrate it.");
    return;
  }
  if (health.width > 0 &&
      (health.width != made->pixel_image_width || health.height != made->pixel_image_height)) {
    add("calibration_other_size", Severity::kBad,
        fmt::format("Camera {} sends {}x{} pixels, its calibration was made for {}x{}", camera.id,
                    health.width, health.height, made->pixel_image_width, made->pixel_image_height),
        "All positions are wrong: set the old picture size, or calibrate again.");
  }
  if (camera.field_changed_since_calibrated) {
    add("calibration_stale", Severity::kWarn,
        fmt::format("The field was changed after camera {} was calibrated on it", camera.id),
        "Calibrate it again, or set the sizes that the field had then.");
  }
}

/// What a second vision does to the teams, which cannot tell whose packets they get.
void add_vision_alerts(std::vector<Alert>& alerts, const HealthInput& input) {
  for (const OtherVision& other : input.other_visions) {
    const auto add = [&](const char* id, Severity severity, std::string title, std::string fix,
                         std::string page) {
      alerts.push_back({.id = id,
                        .check = CheckId::kOtherVisions,
                        .severity = severity,
                        .title = std::move(title),
                        .fix = std::move(fix),
                        .page = std::move(page),
                        .about = other.address});
    };
    std::vector<std::string> shared_ids, conflicts;
    for (const CameraFacts& camera : input.cameras) {
      const auto id = static_cast<std::uint32_t>(camera.id);
      if (std::find(other.cameras.begin(), other.cameras.end(), id) != other.cameras.end()) {
        shared_ids.push_back(std::to_string(id));
      }
    }
    for (const SizeConflict& size : field_conflicts(input, other)) {
      conflicts.push_back(fmt::format("{} is {:g} here and {:g} there", size.name, size.ours, size.theirs));
    }
    if (!shared_ids.empty()) {
      add("vision_same_camera", Severity::kBad,
          fmt::format("Camera id {} is also sent by {}", joined(shared_ids), other.address),
          "Teams mix up what the two cameras see: give each its own id, or end one of the visions.",
          "#/settings/cameras");
    }
    if (!conflicts.empty()) {
      add("vision_other_field", Severity::kBad,
          fmt::format("{} sends another field: {}", other.address, joined(conflicts)),
          "Teams get both in turn: set the same sizes, or end one of the visions.", "#/field");
    }
    if (shared_ids.empty() && conflicts.empty()) {
      add("vision_other", Severity::kInfo, fmt::format("{} sends to the vision group too", other.address),
          "Nothing to do if it is the vision of this field's other cameras; otherwise end it.", "#/field");
    }
  }
}

std::string game_controller_text(const GameController& one) {
  return one.source == one.address ? one.address : fmt::format("{} at {}", one.source, one.address);
}

void add_referee_alerts(std::vector<Alert>& alerts, const HealthInput& input) {
  for (const TeamNow& team : teams_now(input.config.teams, input.referee.team_names)) {
    if (!team.name_is_unknown) continue;
    alerts.push_back({.id = "team_unknown",
                      .check = CheckId::kTeams,
                      .severity = Severity::kWarn,
                      .title = fmt::format("Unknown team \"{}\": its robots are taken to be {:g} mm high",
                                           team.name, team.robot_height_mm),
                      .fix = "Measure the pattern's height and set robot_height in teams.",
                      .page = "#/field",
                      .about = team.name});
  }
  if (const auto& other = input.referee.other) {
    alerts.push_back(
        {.id = "two_game_controllers",
         .check = CheckId::kReferee,
         .severity = Severity::kWarn,
         .title = fmt::format("Two game controllers send: {}, which is followed, and {}",
                              game_controller_text(input.referee.followed), game_controller_text(*other)),
         .fix =
             "End the one that is not this field's, or set network/referee to this field's group and port.",
         .page = "#/settings/network/referee"});
  }
}

void add_network_alerts(std::vector<Alert>& alerts, const HealthInput& input) {
  if (!input.network.error.empty()) {
    alerts.push_back({.id = "not_sending",
                      .check = CheckId::kNetwork,
                      .severity = Severity::kBad,
                      .title = "No packets leave",
                      .fix = input.network.error + "; sending is tried again by itself.",
                      .page = "#/settings/network/vision"});
    return;  // that says what to do about those below too
  }
  const auto add = [&](CheckId check, const std::string& error, const char* group) {
    if (error.empty()) return;
    alerts.push_back({.id = "group_not_heard",
                      .check = check,
                      .severity = Severity::kWarn,
                      .title = "A group cannot be heard",
                      .fix = error + "; it is tried again by itself.",
                      .page = fmt::format("#/settings/network/{}", group),
                      .about = group});
  };
  add(CheckId::kOtherVisions, input.listening_error, "vision");
  add(CheckId::kReferee, input.referee.error, "referee");
}

void add_computer_alerts(std::vector<Alert>& alerts, const HealthInput& input) {
  const auto warn = [&](const char* id, CheckId check, std::string title, std::string fix, const char* page) {
    alerts.push_back({.id = id,
                      .check = check,
                      .severity = Severity::kWarn,
                      .title = std::move(title),
                      .fix = std::move(fix),
                      .page = page});
  };
  // A clock that no other vision's is compared with may be wrong: teams get all times from one clock then.
  if (input.another_host_sends && input.clock && !input.clock->synchronised) {
    warn("clock_not_synchronised", CheckId::kClock,
         "This computer's clock is not synchronised, and another vision sends times too",
         "Turn on time synchronisation: timedatectl set-ntp true", "#/diagnostics");
  }
  if (const auto& disk = input.computer.disk) {
    if (disk->free_bytes < kLittleDisk_bytes ||
        static_cast<double>(disk->free_bytes) < kLittleDiskShare * static_cast<double>(disk->total_bytes)) {
      warn("disk_full", CheckId::kComputer,
           fmt::format("The disk of {} is nearly full: {:.0f} MB are free", disk->folder.string(),
                       static_cast<double>(disk->free_bytes) * 1e-6),
           "Settings cannot be saved on a full disk: delete what is not needed.", "#/diagnostics");
    }
  }
  if (static_cast<double>(input.computer.memory_available_bytes) <
      kLittleMemoryShare * static_cast<double>(input.computer.memory_bytes)) {
    warn("memory_full", CheckId::kComputer,
         fmt::format("This computer's memory is nearly full: {:.0f} MB are free",
                     static_cast<double>(input.computer.memory_available_bytes) * 1e-6),
         "End other programs before the system ends this one.", "#/diagnostics");
  }
  for (const std::string& problem : input.lost_tables) {
    warn("table_lost", CheckId::kPictures, problem,
         "The camera has the table of its settings' classes or file. Learn its colours, import a table, or "
         "take "
         "an older one from the settings' history.",
         "#/colors");
  }
  if (!input.settings_problem.empty()) {
    warn("settings_rejected", CheckId::kComputer, input.settings_problem,
         "Look through the settings and save what is missing again.", "#/settings");
  }
  if (!input.save_problem.empty()) {
    warn("settings_not_saved", CheckId::kComputer,
         fmt::format("The last change was refused, as it could not be saved: {}", input.save_problem),
         "Make room or mend the folder's rights, then make the change again.", "#/settings");
  }
  if (!input.state_problem.empty()) {
    warn("state_not_writable", CheckId::kComputer,
         fmt::format("No change can be saved: {}", input.state_problem),
         "Mend the folder's rights, or mount its disk for writing. All else goes on meanwhile.",
         "#/diagnostics");
  }
  if (!input.reload_problem.empty()) {
    warn("settings_not_reloaded", CheckId::kComputer,
         fmt::format("The settings file was not taken over, the settings before are in force: {}",
                     input.reload_problem),
         "Mend the file, then reload: systemctl reload ssl-visiond", "#/settings");
  }
}

const char* name_of(Severity severity) {
  switch (severity) {
    case Severity::kBad: return "bad";
    case Severity::kWarn: return "warn";
    case Severity::kInfo: break;
  }
  return "info";
}

}  // namespace

std::vector<SizeConflict> field_conflicts(const HealthInput& input, const OtherVision& other) {
  if (!other.field) return {};
  SSL_WrapperPacket ours;
  write_geometry(*input.geometry, ours);
  return size_conflicts(ours.geometry().field(), *other.field);
}

std::vector<Alert> find_alerts(const HealthInput& input) {
  std::vector<Alert> alerts;
  for (const CameraFacts& camera : input.cameras) add_source_alerts(alerts, camera);
  add_network_alerts(alerts, input);
  add_vision_alerts(alerts, input);
  for (const CameraFacts& camera : input.cameras) add_calibration_alerts(alerts, camera);
  for (const CameraFacts& camera : input.cameras) add_picture_alerts(alerts, camera);
  for (const CameraFacts& camera : input.cameras) add_margin_alert(alerts, camera);
  add_referee_alerts(alerts, input);
  add_computer_alerts(alerts, input);
  std::stable_sort(alerts.begin(), alerts.end(),
                   [](const Alert& a, const Alert& b) { return a.severity < b.severity; });
  return alerts;
}

Json to_json(const Alert& alert) {
  return {{"id", alert.id},
          {"severity", name_of(alert.severity)},
          {"title", alert.title},
          {"fix", alert.fix},
          {"camera", alert.camera ? Json(*alert.camera) : Json(nullptr)},
          {"page", alert.page.empty() ? Json(nullptr) : Json(alert.page)},
          {"since", alert.since_s}};
}

void AlertTimes::stamp(std::vector<Alert>& alerts, double now_s, double steady_s) {
  constexpr double kClockWasSet_s = 0.1;
  std::map<Key, Since> next;
  const std::lock_guard lock(mutex_);
  for (Alert& alert : alerts) {
    const Key key{alert.id, alert.camera, alert.about};
    const auto known = since_.find(key);
    Since since = known == since_.end() ? Since{now_s, steady_s} : known->second;
    // The same at every look, unless the clock was set meanwhile.
    const double by_steady_s = now_s - (steady_s - since.steady_s);
    if (std::abs(by_steady_s - since.unix_s) > kClockWasSet_s) since.unix_s = by_steady_s;
    alert.since_s = since.unix_s;
    next[key] = since;
  }
  since_ = std::move(next);
}

}  // namespace sslv
