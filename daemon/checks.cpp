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
  std::string value, unit;  // the figure that says most
  std::string text;         // what was found besides
};

constexpr CheckState kPass = CheckState::kPass, kWarn = CheckState::kWarn, kFail = CheckState::kFail;
constexpr const char* kNothing = "\u2013";  // where there is no figure

bool is_running(const CameraFacts& camera) {
  return camera.health.state == CameraState::kRunning;
}

std::size_t running(const HealthInput& input) {
  return static_cast<std::size_t>(std::count_if(input.cameras.begin(), input.cameras.end(), is_running));
}

Finding look_at_cameras(const HealthInput& input) {
  const std::size_t count = running(input);
  Finding found{kPass, std::to_string(count), fmt::format("of {}", input.cameras.size()), "all run"};
  if (input.cameras.empty()) {
    found.state = kFail;
    found.text = "there is no camera in the settings";
  } else if (count == 0) {
    found.state = kFail;
    found.text = "none runs";
  } else if (count < input.cameras.size()) {
    found.state = kWarn;
    found.text = "not all run";
  }
  return found;
}

Finding look_at_pictures(const HealthInput& input) {
  Timeline::Sum sum;
  double clipped = 0;
  std::optional<double> slowest;
  for (const CameraFacts& camera : input.cameras) {
    if (is_running(camera)) slowest = std::min(slowest.value_or(camera.health.fps), camera.health.fps);
    sum.dropped += camera.last_minute.dropped;
    sum.incomplete += camera.last_minute.incomplete;
    if (camera.exposure) clipped = std::max(clipped, camera.exposure->clipped_share);
  }
  std::string text = sum.dropped + sum.incomplete == 0
                         ? "none lost in 60 s"
                         : fmt::format("{} dropped, {} damaged in 60 s", sum.dropped, sum.incomplete);
  if (clipped >= 0.001) text += fmt::format(", {:.1f} % too bright", 100 * clipped);
  return {kPass, slowest ? fmt::format("{:.1f}", *slowest) : kNothing, "per second", text};
}

Finding look_at_latency(const HealthInput& input) {
  if (running(input) == 0) return {kPass, kNothing, "ms", "no camera runs"};
  double worst_ms = 0;
  for (const CameraFacts& camera : input.cameras) {
    if (is_running(camera)) worst_ms = std::max(worst_ms, camera.latency_p99_ms);
  }
  Finding found{kPass, fmt::format("{:.2f}", worst_ms), "ms",
                fmt::format("p99, limit {:g} ms", kLateAfter_ms)};
  if (worst_ms > kLateAfter_ms) {
    found.state = kWarn;
    found.text += ": end other programs on this computer";
  }
  return found;
}

Finding look_at_calibration(const HealthInput& input) {
  const auto count = std::count_if(input.cameras.begin(), input.cameras.end(),
                                   [](const CameraFacts& camera) { return camera.calibration.has_value(); });
  return {kPass, std::to_string(count), fmt::format("of {}", input.cameras.size()), "all calibrated"};
}

Finding look_at_colors(const HealthInput& input) {
  const CameraFacts::Margin* least = nullptr;
  for (const CameraFacts& camera : input.cameras) {
    if (camera.least_margin && (!least || camera.least_margin->share < least->share))
      least = &*camera.least_margin;
  }
  if (!least) return {kPass, kNothing, "", "margins to carpet and floor are not known yet"};
  const bool is_limited = least->share < CameraFacts::Margin::kMost;
  return {kPass, fmt::format("{}{:.0f}", is_limited ? "" : "> ", 100 * least->share), "% margin",
          least->text.empty() ? "carpet and floor stay clear" : least->text};
}

Finding look_at_network(const HealthInput& input) {
  const MulticastSettings& vision = input.config.network.vision;
  return {kPass, fmt::format("{:.0f}", input.network.packets_per_s), "packets/s",
          fmt::format("to {}:{}", vision.group, vision.port)};
}

Finding look_at_other_visions(const HealthInput& input) {
  const std::size_t count = input.other_visions.size();
  return {kPass, std::to_string(count), count == 1 ? "other" : "others",
          count == 0 ? "nobody else sends here" : "with other cameras"};
}

Finding look_at_referee(const HealthInput& input) {
  const RefereeSettings& settings = input.config.network.referee;
  const RefereeStatus& referee = input.referee;
  if (!settings.enabled) return {kPass, "off", "", "not listened to"};
  if (!referee.silent_s) {
    return {kWarn, kNothing, "", fmt::format("not heard on {}:{}", settings.group, settings.port)};
  }
  const std::string from = fmt::format("from {}", referee.followed.address);
  if (*referee.silent_s <= RefereeListener::kForgottenAfter_s) return {kPass, "heard", "", from};
  return {kWarn, fmt::format("{:.0f}", *referee.silent_s), "s silent", from};
}

Finding look_at_teams(const HealthInput& input) {
  const auto teams = teams_now(input.config.teams, input.referee.team_names);
  const auto height = [&](Team which) {
    return fmt::format("{:g}", teams[static_cast<std::size_t>(which)].robot_height_mm);
  };
  const auto name = [&](Team which) {
    const TeamNow& team = teams[static_cast<std::size_t>(which)];
    return team.name.empty() ? std::string("no name") : team.name;
  };
  return {kPass, fmt::format("{} / {}", height(Team::kYellow), height(Team::kBlue)), "mm",
          fmt::format("{} (yellow), {} (blue)", name(Team::kYellow), name(Team::kBlue))};
}

Finding look_at_clock(const HealthInput& input) {
  if (!input.clock) return {kWarn, kNothing, "", "the system does not say whether it is synchronised"};
  if (!input.clock->synchronised) return {kWarn, kNothing, "", "not synchronised: timedatectl set-ntp true"};
  return {kPass, fmt::format("±{:.1f}", input.clock->estimated_error_ms), "ms", "synchronised"};
}

Finding look_at_computer(const HealthInput& input) {
  constexpr double kGb = 1e-9;
  std::string text =
      fmt::format("{:.1f} GB memory", static_cast<double>(input.computer.memory_available_bytes) * kGb);
  if (const auto& disk = input.computer.disk)
    text += fmt::format(", {:.0f} GB disk free", static_cast<double>(disk->free_bytes) * kGb);
  if (const auto& celsius = input.computer.temperature_c) text += fmt::format(", {:.0f} °C", *celsius);
  return {kPass, fmt::format("{:.1f}", input.computer.load[0]), "load", text};
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
    CheckKind{CheckId::kColors, "colors", "Colours", look_at_colors},
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
    auto [state, value, unit, text] = kind.look(input);
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
    checks.push_back({kind.id, state, std::move(value), std::move(unit), std::move(text)});
  }
  return checks;
}

bool is_go(const std::vector<Check>& checks) {
  return std::none_of(checks.begin(), checks.end(),
                      [](const Check& check) { return check.state == CheckState::kFail; });
}

Json to_json(const Check& check) {
  const CheckKind& kind = kind_of(check.id);
  return {{"id", kind.name},      {"title", kind.title}, {"state", name_of(check.state)},
          {"value", check.value}, {"unit", check.unit},  {"text", check.text}};
}

}  // namespace sslv
