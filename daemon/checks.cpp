// SPDX-License-Identifier: Apache-2.0
#include "checks.h"

#include "teams.h"

#include <algorithm>
#include <array>
#include <optional>

#include <fmt/format.h>

namespace sslv {
namespace {

/// Late by more than this, a packet is late by as much as a ball at 6 m/s takes for 30 mm.
constexpr double kLateAfter_ms = 5;

struct Finding {
  CheckState state;
  std::string text;
};

Finding pass(std::string text) {
  return {CheckState::kPass, std::move(text)};
}

bool is_running(const CameraFacts& camera) {
  return camera.health.state == CameraState::kRunning;
}

std::size_t running(const HealthInput& input) {
  return static_cast<std::size_t>(std::count_if(input.cameras.begin(), input.cameras.end(), is_running));
}

Finding look_at_cameras(const HealthInput& input) {
  if (input.cameras.empty()) return {CheckState::kFail, "there is no camera in the settings"};
  std::optional<double> slowest;
  for (const CameraFacts& camera : input.cameras) {
    if (is_running(camera)) slowest = std::min(slowest.value_or(camera.health.fps), camera.health.fps);
  }
  const std::size_t count = running(input);
  const std::string text = fmt::format("{} of {} running", count, input.cameras.size());
  if (!slowest) return {CheckState::kFail, text};
  return {count < input.cameras.size() ? CheckState::kWarn : CheckState::kPass,
          text + fmt::format(", {:.1f} frames/s", *slowest)};
}

Finding look_at_pictures(const HealthInput& input) {
  Timeline::Sum sum;
  double clipped = 0;
  bool has_exposure = false;
  for (const CameraFacts& camera : input.cameras) {
    sum.frames += camera.last_minute.frames;
    sum.dropped += camera.last_minute.dropped;
    sum.incomplete += camera.last_minute.incomplete;
    if (!camera.exposure) continue;
    has_exposure = true;
    clipped = std::max(clipped, camera.exposure->clipped_share);
  }
  std::string text =
      fmt::format("{} in the last minute, {} dropped, {} damaged", sum.all(), sum.dropped, sum.incomplete);
  if (has_exposure) text += fmt::format(", at most {:.1f} % too bright", 100 * clipped);
  return pass(text);
}

Finding look_at_latency(const HealthInput& input) {
  if (running(input) == 0) return pass("no camera runs");
  double worst_ms = 0;
  for (const CameraFacts& camera : input.cameras) {
    if (is_running(camera)) worst_ms = std::max(worst_ms, camera.latency_p99_ms);
  }
  const std::string text = fmt::format("{:.1f} ms from picture to packet (99 of 100)", worst_ms);
  if (worst_ms <= kLateAfter_ms) return pass(text);
  return {CheckState::kWarn,
          fmt::format("{}, {:g} ms would be good: end other programs on this computer", text, kLateAfter_ms)};
}

Finding look_at_calibration(const HealthInput& input) {
  return pass(fmt::format("all {} calibrated", input.cameras.size()));
}

Finding look_at_network(const HealthInput& input) {
  const MulticastSettings& vision = input.config.network.vision;
  return pass(fmt::format("packets to {}:{}, {:.0f} per second", vision.group, vision.port,
                          input.network.packets_per_s));
}

Finding look_at_other_visions(const HealthInput& input) {
  if (input.other_visions.empty()) return pass("nobody else sends to the vision group");
  return pass(fmt::format("{} more, with other cameras", input.other_visions.size()));
}

Finding look_at_referee(const HealthInput& input) {
  const RefereeSettings& settings = input.config.network.referee;
  const RefereeStatus& referee = input.referee;
  if (!settings.enabled) return pass("not listened to");
  if (!referee.silent_s) {
    return {CheckState::kWarn,
            fmt::format("no game controller was heard on {}:{}", settings.group, settings.port)};
  }
  const std::string text = fmt::format("heard from {}", referee.followed.address);
  if (*referee.silent_s <= RefereeListener::kForgottenAfter_s) return pass(text);
  return {CheckState::kWarn, text + fmt::format(", {:.0f} s ago", *referee.silent_s)};
}

Finding look_at_teams(const HealthInput& input) {
  const auto teams = teams_now(input.config.teams, input.referee.team_names);
  const auto one = [&](Team which) {
    const TeamNow& team = teams[static_cast<std::size_t>(which)];
    return fmt::format("{} {:g} mm", team.name.empty() ? "no name" : team.name, team.robot_height_mm);
  };
  return pass(fmt::format("yellow: {}, blue: {}", one(Team::kYellow), one(Team::kBlue)));
}

Finding look_at_clock(const HealthInput& input) {
  if (!input.clock) return {CheckState::kWarn, "the system does not say whether it is synchronised"};
  if (!input.clock->synchronised) return {CheckState::kWarn, "not synchronised: timedatectl set-ntp true"};
  return pass(fmt::format("synchronised, estimated error {:.1f} ms", input.clock->estimated_error_ms));
}

Finding look_at_computer(const HealthInput& input) {
  constexpr double kGb = 1e-9;
  std::string text = fmt::format("load {:.1f}, {:.1f} GB of memory free", input.computer.load[0],
                                 static_cast<double>(input.computer.memory_available_bytes) * kGb);
  if (const auto& disk = input.computer.disk)
    text += fmt::format(", {:.1f} GB of disk free", static_cast<double>(disk->free_bytes) * kGb);
  if (const auto& celsius = input.computer.temperature_c) text += fmt::format(", {:.0f} °C", *celsius);
  return pass(text);
}

struct CheckKind {
  CheckId id;
  const char *name, *title;
  Finding (*look)(const HealthInput&);  // what is found, alerts aside
};

constexpr std::array kChecks{
    CheckKind{CheckId::kCameras, "cameras", "Cameras", look_at_cameras},
    CheckKind{CheckId::kPictures, "pictures", "Pictures", look_at_pictures},
    CheckKind{CheckId::kLatency, "latency", "Latency", look_at_latency},
    CheckKind{CheckId::kCalibration, "calibration", "Calibration", look_at_calibration},
    CheckKind{CheckId::kNetwork, "network", "Network", look_at_network},
    CheckKind{CheckId::kOtherVisions, "other_visions", "One vision", look_at_other_visions},
    CheckKind{CheckId::kReferee, "referee", "Game controller", look_at_referee},
    CheckKind{CheckId::kTeams, "teams", "Teams", look_at_teams},
    CheckKind{CheckId::kClock, "clock", "Clock", look_at_clock},
    CheckKind{CheckId::kComputer, "computer", "This computer", look_at_computer},
};

const CheckKind& kind_of(CheckId id) {
  return *std::find_if(kChecks.begin(), kChecks.end(), [&](const CheckKind& kind) { return kind.id == id; });
}

const char* name_of(CheckState state) {
  switch (state) {
    case CheckState::kPass: return "pass";
    case CheckState::kWarn: return "warn";
    case CheckState::kFail: break;
  }
  return "fail";
}

}  // namespace

std::vector<Check> make_checks(const HealthInput& input, const std::vector<Alert>& alerts) {
  std::vector<Check> checks;
  for (const CheckKind& kind : kChecks) {
    auto [state, text] = kind.look(input);
    // Alerts say more than what was found alone: the worst stands there instead, unless it only informs.
    const auto is_ours = [&](const Alert& alert) {
      return alert.check == kind.id && alert.severity != Severity::kInfo;
    };
    const auto worst = std::find_if(alerts.begin(), alerts.end(), is_ours);
    if (worst != alerts.end()) {
      const auto count = std::count_if(alerts.begin(), alerts.end(), is_ours);
      text = worst->title;
      if (count > 1) text += fmt::format(" (and {} more)", count - 1);
      state = std::max(state, worst->severity == Severity::kBad ? CheckState::kFail : CheckState::kWarn);
    }
    checks.push_back({kind.id, state, std::move(text)});
  }
  return checks;
}

bool is_go(const std::vector<Check>& checks) {
  return std::none_of(checks.begin(), checks.end(),
                      [](const Check& check) { return check.state == CheckState::kFail; });
}

Json to_json(const Check& check) {
  const CheckKind& kind = kind_of(check.id);
  return {{"id", kind.name}, {"title", kind.title}, {"state", name_of(check.state)}, {"text", check.text}};
}

}  // namespace sslv
