// SPDX-License-Identifier: Apache-2.0
#include "services/network/network_report.h"

#include "services/network/teams.h"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

std::string joined(const std::vector<std::string>& texts) {
  return fmt::format("{}", fmt::join(texts, ", "));
}

/// Adds alerts about other visions, because teams cannot distinguish the packets of two visions.
void add_vision_alerts(HealthReport& report, const NetworkFacts& facts) {
  std::vector<Alert> same_camera, other_field, unnamed;
  for (const OtherVision& other : facts.other_visions) {
    const auto add = [&](std::vector<Alert>& to, const char* id, Severity severity, std::string title,
                         std::string fix, std::string page) {
      to.push_back({.id = id,
                    .check = "other_visions",
                    .severity = severity,
                    .title = std::move(title),
                    .fix = std::move(fix),
                    .page = std::move(page)});
    };
    std::vector<std::string> shared_ids, conflicts;
    for (const CameraSettings& camera : facts.config->cameras) {
      if (std::find(other.cameras.begin(), other.cameras.end(), camera.id) != other.cameras.end())
        shared_ids.push_back(std::to_string(camera.id));
    }
    for (const SizeConflict& size : field_conflicts(facts, other)) {
      conflicts.push_back(fmt::format("{} is {:g} here and {:g} there", size.name, size.ours, size.theirs));
    }
    if (!shared_ids.empty()) {
      add(same_camera, "vision_same_camera", Severity::kBad,
          fmt::format("Camera id {} is also sent by {}", joined(shared_ids), other.address),
          "Teams mix up the detections of the two cameras: give each its own id, or stop one of the vision "
          "services.",
          "#/settings/cameras");
    }
    if (!conflicts.empty()) {
      add(other_field, "vision_other_field", Severity::kBad,
          fmt::format("{} sends another field: {}", other.address, joined(conflicts)),
          "Teams get both in turn: set the same sizes, or stop one of the vision services.", "#/field");
    }
    if (shared_ids.empty() && conflicts.empty() && !other.is_named) {
      add(unnamed, "vision_other", Severity::kInfo,
          fmt::format("{} also sends {}to the vision group{}", other.address,
                      !other.cameras.empty() ? ""
                      : other.field          ? "a geometry "
                                             : "other messages ",
                      other.cameras.empty() ? "" : "; its cameras are shown, but not used for tracks"),
          fmt::format(
              "If it is a computer of this field, add {} to field/other_computers; otherwise stop it.",
              other.address),
          "#/settings/field");
    }
  }
  for (auto* kind : {&same_camera, &other_field, &unnamed}) report.add_as_one(std::move(*kind));
}

std::string game_controller_text(const GameController& one) {
  return one.source == one.address ? one.address : fmt::format("{} at {}", one.source, one.address);
}

void add_referee_alerts(std::vector<Alert>& alerts, const NetworkFacts& facts) {
  for (const TeamNow& team : teams_now(facts.config->teams, facts.referee.team_names)) {
    if (!team.name_is_unknown) continue;
    alerts.push_back({.id = "team_unknown",
                      .check = "teams",
                      .severity = Severity::kWarn,
                      .title = fmt::format("Unknown team \"{}\": its robots are assumed to be {:g} mm high",
                                           team.name, team.robot_height_mm),
                      .fix =
                          "Measure the height of its pattern. Then set robot_height and name of this team: "
                          "the name shows that the height is this team's.",
                      .page = "#/field",
                      .about = team.name});
  }
  if (const auto& other = facts.referee.other) {
    alerts.push_back(
        {.id = "two_game_controllers",
         .check = "referee",
         .severity = Severity::kWarn,
         .title = fmt::format("Two game controllers send: {}, which is followed, and {}",
                              game_controller_text(facts.referee.followed), game_controller_text(*other)),
         .fix = "Stop the one that does not belong to this field, or set network/referee to this field's "
                "group and port.",
         .page = "#/settings/network/referee"});
  }
}

void add_network_alerts(std::vector<Alert>& alerts, const NetworkFacts& facts) {
  if (!facts.multicast.error.empty()) {
    alerts.push_back({.id = "not_sending",
                      .check = "network",
                      .severity = Severity::kBad,
                      .title = title_not_sent("packets", facts.multicast.some_leave),
                      .fix = facts.multicast.error + "; the service tries again automatically.",
                      .page = "#/settings/network/vision"});
    return;  // this alert's fix covers the problems below too
  }
  if (const std::string& card = facts.cards.without_link; !card.empty()) {
    alerts.push_back(
        {.id = "card_no_link",
         .check = "network",
         .severity = Severity::kBad,
         .title = fmt::format("Network card {} has no link: no packet reaches the teams", card),
         .fix = "Check its cable and the switch, or set network/vision/interface to another card.",
         .page = "#/settings/network/vision"});
  }
  if (!facts.cards.unused.empty()) {
    alerts.push_back(
        {.id = "only_this_computer",
         .check = "network",
         .severity = Severity::kWarn,
         .title = "Packets reach only programs on this computer",
         .fix = fmt::format("Set network/vision/interface to the card of the teams' network, such as {}.",
                            facts.cards.unused),
         .page = "#/settings/network/vision"});
  }
  if (const CardsUsed& cards = facts.cards; !cards.heard_on.empty()) {
    alerts.push_back(
        {.id = "card_wrong",
         .check = "network",
         .severity = Severity::kWarn,
         .title = fmt::format("Packets leave on network card {}, but the field's computer {} is on {}",
                              cards.sender, cards.heard, cards.heard_on),
         .fix = fmt::format("Set network/vision/interface to {}.", cards.heard_on),
         .page = "#/settings/network/vision"});
  } else if (!cards.others.empty()) {
    alerts.push_back(
        {.id = "card_not_chosen",
         .check = "network",
         .severity = Severity::kWarn,
         .title = fmt::format("No network card is chosen: packets leave on {}", cards.sender),
         .fix = fmt::format("Set network/vision/interface to the card of the teams' network: this one, "
                            "or {}.",
                            cards.others),
         .page = "#/settings/network/vision"});
  }
  const auto add = [&](const char* check, const std::string& error, const char* group) {
    if (error.empty()) return;
    alerts.push_back({.id = "group_not_heard",
                      .check = check,
                      .severity = Severity::kWarn,
                      .title = "No packets can be received from a multicast group",
                      .fix = error + "; the service tries again automatically.",
                      .page = fmt::format("#/settings/network/{}", group),
                      .about = group});
  };
  add("other_visions", facts.listening_error, "vision");
  add("referee", facts.referee.error, "referee");
}

Check check_network(const NetworkFacts& facts) {
  const MulticastSettings& vision = facts.config->network.vision;
  return {"network",
          "Network",
          CheckState::kPass,
          fmt::format("{:.0f}", facts.multicast.packets_per_s),
          "packets/s",
          fmt::format("to {}:{}{}", vision.group, vision.port,
                      facts.cards.sender.empty() ? "" : " on " + facts.cards.sender)};
}

Check check_other_visions(const NetworkFacts& facts) {
  const std::size_t count = facts.other_visions.size();
  return {"other_visions",
          "One vision",
          CheckState::kPass,
          std::to_string(count),
          count == 1 ? "other" : "others",
          count == 0 ? "nobody else sends here" : "with other cameras"};
}

Check check_referee(const NetworkFacts& facts) {
  const RefereeSettings& settings = facts.config->network.referee;
  const RefereeStatus& referee = facts.referee;
  Check check{"referee", "Game controller", CheckState::kPass, "off", "", "not listened to"};
  if (!settings.enabled) return check;
  check.state = CheckState::kWarn;
  if (!referee.silent_s) {
    check.value = kNoFigure;
    check.text = fmt::format("not heard on {}:{}", settings.group, settings.port);
    return check;
  }
  check.text = fmt::format("from {}", referee.followed.address);
  if (*referee.silent_s <= RefereeListener::kForgottenAfter_s) {
    check.state = CheckState::kPass;
    check.value = "heard";
  } else {
    check.value = fmt::format("{:.0f}", *referee.silent_s);
    check.unit = "s silent";
  }
  return check;
}

Check check_teams(const NetworkFacts& facts) {
  const auto teams = teams_now(facts.config->teams, facts.referee.team_names);
  const auto height = [&](Team which) {
    return fmt::format("{:g}", teams[static_cast<std::size_t>(which)].robot_height_mm);
  };
  const auto name = [&](Team which) {
    const TeamNow& team = teams[static_cast<std::size_t>(which)];
    return team.name.empty() ? std::string("no name") : team.name;
  };
  return {"teams",
          "Teams",
          CheckState::kPass,
          fmt::format("{} / {}", height(Team::kYellow), height(Team::kBlue)),
          "mm",
          fmt::format("{} (yellow), {} (blue)", name(Team::kYellow), name(Team::kBlue))};
}

Json teams_json(const NetworkFacts& facts) {
  const auto teams = teams_now(facts.config->teams, facts.referee.team_names);
  const auto one = [&](Team which) {
    const TeamNow& team = teams[static_cast<std::size_t>(which)];
    return Json{{"name", team.name},
                {"robot_height", team.robot_height_mm},
                {"height_from", team.height_is_known ? "referee" : "settings"}};
  };
  return {{"yellow", one(Team::kYellow)}, {"blue", one(Team::kBlue)}};
}

Json other_visions_json(const NetworkFacts& facts) {
  Json out = Json::array();
  for (const OtherVision& other : facts.other_visions) {
    Json conflicts = Json::array();
    for (const SizeConflict& size : field_conflicts(facts, other)) {
      conflicts.push_back({{"name", size.name}, {"ours", size.ours}, {"theirs", size.theirs}});
    }
    out.push_back({{"address", other.address},
                   {"is_named", other.is_named},
                   {"silent_s", other.silent_s},
                   {"cameras", other.cameras},
                   {"field_conflicts", std::move(conflicts)}});
  }
  return out;
}

Json game_controller_json(const GameController& one) {
  return {{"source", one.source}, {"address", one.address}};
}

/// Names of the stages, indexed by the game controller's stage numbers.
constexpr std::array kStages{"first_half_before",
                             "first_half",
                             "half_time",
                             "second_half_before",
                             "second_half",
                             "extra_time_break",
                             "extra_first_half_before",
                             "extra_first_half",
                             "extra_half_time",
                             "extra_second_half_before",
                             "extra_second_half",
                             "shootout_break",
                             "shootout",
                             "finished"};

Json match_json(const MatchState& match) {
  const bool is_known = match.stage >= 0 && static_cast<std::size_t>(match.stage) < kStages.size();
  return {{"stage", is_known ? kStages[static_cast<std::size_t>(match.stage)] : "unknown"},
          {"time_left_s", match.time_left_s ? Json(*match.time_left_s) : Json(nullptr)},
          {"score", {{"yellow", match.score[0]}, {"blue", match.score[1]}}}};
}

Json referee_json(const NetworkFacts& facts) {
  const RefereeSettings& settings = facts.config->network.referee;
  const RefereeStatus& referee = facts.referee;
  return {{"enabled", settings.enabled},
          {"group", settings.group},
          {"port", settings.port},
          {"error", referee.error},
          {"source", referee.followed.source},
          {"address", referee.followed.address},
          {"other", referee.other ? game_controller_json(*referee.other) : Json(nullptr)},
          {"silent_s", referee.silent_s ? Json(*referee.silent_s) : Json(nullptr)},
          {"game_is_running", referee.game_is_running},
          {"match", referee.match ? match_json(*referee.match) : Json(nullptr)},
          {"packets_refused", referee.refused}};
}

}  // namespace

std::vector<SizeConflict> field_conflicts(const NetworkFacts& facts, const OtherVision& other) {
  if (!other.field) return {};
  SSL_WrapperPacket ours;
  write_geometry(*facts.geometry, ours);
  return size_conflicts(ours.geometry().field(), *other.field);
}

void report_network(const NetworkFacts& facts, HealthReport& report) {
  report.another_host_sends = facts.another_host_sends;
  add_network_alerts(report.alerts, facts);
  add_vision_alerts(report, facts);
  add_referee_alerts(report.alerts, facts);
  for (const auto check : {check_network, check_other_visions, check_referee, check_teams})
    report.checks.push_back(check(facts));
}

void add_network_status(const NetworkFacts& facts, Json& status) {
  const MulticastSettings& vision = facts.config->network.vision;
  status["network"] = {{"group", vision.group},
                       {"port", vision.port},
                       {"interface", vision.interface},
                       {"error", facts.multicast.error},
                       {"packets_sent", facts.multicast.packets_sent},
                       {"send_errors", facts.multicast.send_errors},
                       {"packets_per_s", facts.multicast.packets_per_s},
                       {"packets_refused", facts.refused_packets},
                       {"other_visions", other_visions_json(facts)}};
  status["referee"] = referee_json(facts);
  status["teams"] = teams_json(facts);
}

}  // namespace sslv
