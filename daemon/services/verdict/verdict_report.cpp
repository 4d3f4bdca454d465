// SPDX-License-Identifier: Apache-2.0
#include "services/verdict/verdict_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sslv {
namespace {

// Positions are accurate to a few millimetres. A robot's pattern is 170 mm wide, and half of that decides a
// duel.
constexpr double kWarnMm = 25, kBadMm = 60;
/// Largest acceptable share of a camera's visible line points at which no line is found.
constexpr double kMissingShare = 0.4;
/// Shares of the field's grid points that no camera covers: alert, severe alert.
constexpr double kUncoveredShare = 0.01, kUncoveredBadShare = 0.1;
/// A missing ball is reported after kBallGone_s, or after kBallHidden_s in a match: robots hide it for a
/// moment, in a match for longer, and people take it off the field.
constexpr double kBallGone_s = 3, kBallHidden_s = 15;
/// Other robots cannot hide a whole team.
constexpr double kTeamGone_s = 3;
/// Time from the service's start until every robot in view was seen.
constexpr double kWatched_s = 5;

std::string place_text(const Eigen::Vector2d& place_mm) {
  return fmt::format("({:.0f}, {:.0f}) mm", place_mm.x(), place_mm.y());
}

void add(HealthReport& report, Alert alert) {
  report.alerts.push_back(std::move(alert));
}

/// "yellow 0, 3 and blue 7"
std::string names_of(const std::vector<LostRobot>& robots) {
  std::vector<std::string> parts;
  for (const Team team : {Team::kYellow, Team::kBlue}) {
    std::vector<int> ids;
    for (const LostRobot& robot : robots) {
      if (robot.team == team) ids.push_back(robot.id);
    }
    if (!ids.empty()) parts.push_back(fmt::format("{} {}", name_of(team), fmt::join(ids, ", ")));
  }
  return fmt::format("{}", fmt::join(parts, " and "));
}

/// Titles contain no durations: alerts have a time of their own, and screen readers would repeat a changing
/// title.
void report_lost(const VerdictFacts& facts, HealthReport& report) {
  const FieldSeen& field = facts.seen.field;
  if (field.lost.empty()) return;
  const std::size_t seen = field.ids[0].size() + field.ids[1].size();
  const LostRobot& newest = *std::ranges::min_element(field.lost, {}, &LostRobot::gone_s);
  // In a HALT or a timeout, people may take off any number.
  std::size_t at_once = 0;
  for (const LostRobot& robot : field.lost) {
    if (!robot.was_handled) at_once = std::max(at_once, robot.at_once);
  }
  const bool is_one = field.lost.size() == 1;
  const bool are_many = at_once >= Sightings::kMany;
  add(report,
      {.id = "robots_lost",
       .check = "robots",
       // A single robot may have been taken off. Many at once were not.
       .severity = are_many || (at_once >= 2 && at_once >= seen) ? Severity::kBad : Severity::kWarn,
       .title = fmt::format("{} {} no longer seen, the last at {}", names_of(field.lost),
                            is_one ? "is" : "are", place_text(newest.place_mm)),
       .fix = is_one ? "Check its pattern and the light there. If it was taken off the field, this alert "
                       "ends after a minute."
                     : fmt::format(
                           "Check light, colours and cameras. If they were taken off the field, this alert "
                           "ends {}.",
                           are_many && facts.match_runs
                               ? "when fewer than three are missing, or when the half ends"
                               : "after a minute"),
       .page = "#/"});
}

/// Before a match teams may be late. During a match no team plays without robots.
void report_none(const VerdictFacts& facts, HealthReport& report) {
  if (!facts.match_runs || facts.robots_are_handled || facts.seen.watched_s < kWatched_s) return;
  std::vector<Team> none;
  for (const Team team : {Team::kYellow, Team::kBlue}) {
    const auto index = static_cast<std::size_t>(team);
    const bool is_gone = facts.seen.field.team_gone_s[index].value_or(kTeamGone_s) >= kTeamGone_s;
    if (is_gone && facts.robots_allowed[index] != 0) none.push_back(team);
  }
  if (none.empty()) return;
  const bool is_one = none.size() == 1;
  add(report,
      {.id = "robots_none",
       .check = "robots",
       .severity = is_one ? Severity::kWarn : Severity::kBad,
       .title = fmt::format("No {}robot is seen while a match is played",
                            is_one ? fmt::format("{} ", name_of(none[0])) : ""),
       .fix = "Check light, colours and cameras in the images. If the robots were taken off the field, "
              "this alert ends when they are back, or in a HALT.",
       .page = "#/"});
}

void report_ball(const VerdictFacts& facts, HealthReport& report) {
  const double patience_s = facts.match_runs ? kBallHidden_s : kBallGone_s;
  const auto& gone_s = facts.seen.field.ball_gone_s;
  if (!gone_s || *gone_s < patience_s) return;
  add(report,
      {.id = "ball_lost",
       .check = "robots",
       .severity = Severity::kWarn,
       .title = "The ball is no longer seen",
       .fix = "Check the light and the colour orange. If the ball was taken off the field, this alert ends "
              "after a minute.",
       .page = "#/colours"});
}

/// The ids of a team's roster; empty: any robot may play.
const std::vector<int>& roster_of(const VerdictFacts& facts, Team team) {
  const TeamsSettings& teams = facts.config.teams;
  return (team == Team::kYellow ? teams.yellow : teams.blue).ids;
}

void report_roster(const VerdictFacts& facts, HealthReport& report) {
  if (facts.match_runs || facts.seen.watched_s < kWatched_s) return;
  for (const Team team : {Team::kYellow, Team::kBlue}) {
    const auto& seen = facts.seen.field.ids[static_cast<std::size_t>(team)];
    std::vector<int> missing;
    for (const int id : roster_of(facts, team)) {
      const bool is_lost = std::ranges::any_of(facts.seen.field.lost, [&](const LostRobot& robot) {
        return robot.team == team && robot.id == id;
      });
      if (!is_lost && !std::ranges::binary_search(seen, id)) missing.push_back(id);
    }
    if (missing.empty()) continue;
    add(report, {.id = "robots_missing",
                 .check = "robots",
                 .severity = Severity::kWarn,
                 .title = fmt::format("{} {} of the roster {} not seen", name_of(team),
                                      fmt::join(missing, ", "), missing.size() == 1 ? "is" : "are"),
                 .fix = "Put them on the field, or remove them from the ids that play (teams).",
                 .page = "#/settings/teams",
                 .about = name_of(team)});
  }
}

void report_allowed(const VerdictFacts& facts, HealthReport& report) {
  if (!facts.half_is_next || facts.seen.watched_s < kWatched_s) return;
  for (const Team team : {Team::kYellow, Team::kBlue}) {
    const auto allowed = facts.robots_allowed[static_cast<std::size_t>(team)];
    const std::size_t seen = facts.seen.field.on_field(team);
    if (!allowed || seen <= static_cast<std::size_t>(*allowed)) continue;
    add(report,
        {.id = "robots_many",
         .check = "robots",
         .severity = Severity::kWarn,
         .title = fmt::format("{}: {} seen, the game controller allows {}", name_of(team),
                              seen == 1 ? "1 robot is" : fmt::format("{} robots are", seen), *allowed),
         .fix = "Take the others off the field, or behind their own goal into the substitution area, or "
                "correct the game controller.",
         .page = "#/settings/teams",
         .about = name_of(team)});
  }
}

void report_doubles(const VerdictFacts& facts, HealthReport& report) {
  for (const DoubleRobot& robot : facts.seen.field.doubles) {
    const std::string name = fmt::format("{} {}", name_of(robot.team), robot.id);
    add(report,
        {.id = "robot_twice",
         .check = "robots",
         .severity = Severity::kBad,
         .title = fmt::format("Two robots are {}: at {} and at {}", name, place_text(robot.places_mm[0]),
                              place_text(robot.places_mm[1])),
         .fix =
             "Give one of them a different id. If there is only one such robot, calibrate the cameras again.",
         .page = "#/",
         .about = name});
  }
}

void report_size(const VerdictFacts& facts, HealthReport& report) {
  for (const auto& [id, lines] : facts.seen.lines) {
    if (!lines.better_size) continue;
    const FieldSize &ours = facts.config.field, &better = lines.better_size->size;
    add(report,
        {.id = "field_size",
         .check = "agreement",
         .severity = Severity::kBad,
         .title = fmt::format("Camera {}: the painted lines match {} ({:g} x {:g} m), not the field's sizes "
                              "({:g} x {:g} m)",
                              id, lines.better_size->help, better.field_length * 1e-3,
                              better.field_width * 1e-3, ours.field_length * 1e-3, ours.field_width * 1e-3),
         .fix = "Set the sizes of this field.",
         .page = "#/field",
         .camera = id});
  }
}

void report_lines(const VerdictFacts& facts, HealthReport& report) {
  for (const auto& [id, lines] : facts.seen.lines) {
    const auto say = [&, camera = id](const char* kind, Severity severity, std::string title,
                                      std::string fix) {
      add(report, {.id = kind,
                   .check = "agreement",
                   .severity = severity,
                   .title = std::move(title),
                   .fix = std::move(fix),
                   .page = fmt::format("#/calibration/{}", camera),
                   .camera = camera});
    };
    if (lines.verdict.missing_share > kMissingShare) {
      say("lines_missing", Severity::kBad,
          fmt::format("Camera {}: {:.0f} % of the painted lines are not where they should be", id,
                      100 * lines.verdict.missing_share),
          "Compare the field's sizes with the real field, then calibrate again.");
    } else if (lines.verdict.worst_mm > kWarnMm) {
      say("lines_off", lines.verdict.worst_mm > kBadMm ? Severity::kBad : Severity::kWarn,
          fmt::format("Camera {}: {} lies {:.0f} mm from where the calibration puts it", id, lines.worst_line,
                      lines.verdict.worst_mm),
          "If the camera was moved, calibrate it again. If not, compare the field's sizes with the real "
          "field.");
    }
  }
}

void report_overlaps(const VerdictFacts& facts, HealthReport& report) {
  for (const Overlap& overlap : facts.seen.field.overlaps) {
    if (overlap.apart_mm <= kWarnMm) continue;
    const Severity severity = overlap.apart_mm > kBadMm ? Severity::kBad : Severity::kWarn;
    const Alert* moved = nullptr;
    for (const int camera : overlap.cameras) {
      const Alert* alert = report.line_alert(camera);
      if (alert && (!moved || alert->severity < moved->severity)) moved = alert;
    }
    if (moved && moved->severity <= severity) continue;
    add(report, {.id = "cameras_disagree",
                 .check = "agreement",
                 .severity = severity,
                 .title = fmt::format("Cameras {} and {} see the same robots {:.0f} mm apart",
                                      overlap.cameras[0], overlap.cameras[1], overlap.apart_mm),
                 .fix = "Check the teams' robot heights, then calibrate these cameras together.",
                 .page = moved ? moved->page : "#/calibration",
                 .about = fmt::format("{} {}", overlap.cameras[0], overlap.cameras[1])});
  }
}

void report_coverage(const VerdictFacts& facts, HealthReport& report) {
  for (const int id : facts.coverage.blind) {
    add(report, {.id = "mask_hides_all",
                 .check = "coverage",
                 .severity = Severity::kBad,
                 .title = fmt::format("Camera {} sees nothing: its mask hides the whole image", id),
                 .fix = "Remove polygons on its page, or set mask/beyond_boundary to null.",
                 .page = fmt::format("#/camera/{}", id),
                 .camera = id});
  }
  // Ignore places that only a lost camera covers: the camera is the problem.
  const auto& uncovered = facts.coverage.out_of_reach_mm;
  const double share =
      facts.coverage.places == 0 ? 0 : static_cast<double>(uncovered.size()) / facts.coverage.places;
  if (share <= kUncoveredShare) return;
  add(report, {.id = "field_uncovered",
               .check = "coverage",
               .severity = share > kUncoveredBadShare ? Severity::kBad : Severity::kWarn,
               .title = fmt::format("{:.0f} % of the field, around {}, is seen by no camera", 100 * share,
                                    place_text(middle_of_largest(uncovered))),
               .fix = "Turn the cameras, use wider lenses, or remove masks that cover the field.",
               .page = "#/field"});
}

Check check_robots(const VerdictFacts& facts) {
  const FieldSeen& field = facts.seen.field;
  const auto& ids = field.ids;
  Check check{
      "robots",          "Robots",
      CheckState::kPass, fmt::format("{} / {}", field.on_field(Team::kYellow), field.on_field(Team::kBlue)),
      "yellow / blue",   field.ball ? "and a ball" : "no ball is seen"};
  if (!field.waiting[0].empty() || !field.waiting[1].empty()) {
    check.text += fmt::format("; {} / {} more wait behind their own goals", field.waiting[0].size(),
                              field.waiting[1].size());
  }
  if (facts.robots_allowed[0] && facts.robots_allowed[1])
    check.text += fmt::format("; {} / {} may play", *facts.robots_allowed[0], *facts.robots_allowed[1]);
  if (facts.match_runs) return check;
  const bool is_ball_seen = field.ball || field.ball_gone_s;  // or the ball is hidden for a moment
  if (ids[0].empty() && ids[1].empty()) {
    check.state = CheckState::kWarn;
    check.text = is_ball_seen ? "a ball, but no robot: put some on the field to check that they are detected"
                              : "nothing is seen: put robots on the field to check that they are detected";
  } else if (!is_ball_seen) {
    check.state = CheckState::kWarn;
    check.text = "no ball is seen: put one on the field to check that it is detected";
  }
  return check;
}

Check check_agreement(const VerdictFacts& facts) {
  std::optional<double> lines_mm, cameras_mm;
  for (const auto& [id, lines] : facts.seen.lines)
    lines_mm = std::max(lines_mm.value_or(0), lines.verdict.worst_mm);
  for (const Overlap& overlap : facts.seen.field.overlaps)
    cameras_mm = std::max(cameras_mm.value_or(0), overlap.apart_mm);
  Check check{"agreement", "Agreement", CheckState::kUnknown,
              kNoFigure,   "",          "no line can be seen well enough"};
  if (!lines_mm && !cameras_mm) return check;
  check.state = CheckState::kPass;
  check.unit = "mm";
  check.value = fmt::format("{:.0f}", std::max(lines_mm.value_or(0), cameras_mm.value_or(0)));
  std::vector<std::string> parts;
  if (lines_mm) parts.push_back(fmt::format("lines {:.0f} mm", *lines_mm));
  if (cameras_mm) parts.push_back(fmt::format("between cameras {:.0f} mm", *cameras_mm));
  check.text = fmt::format("{}", fmt::join(parts, ", "));
  return check;
}

Check check_coverage(const VerdictFacts& facts) {
  Check check{"coverage", "Coverage", CheckState::kUnknown,
              kNoFigure,  "",         "known once all cameras are calibrated"};
  if (!facts.coverage.is_known) return check;
  check.state = CheckState::kPass;
  const auto uncovered = static_cast<double>(facts.coverage.uncovered_mm.size());
  check.value = fmt::format("{:.0f}", 100 * (1 - uncovered / std::max(1, facts.coverage.places)));
  check.unit = "% of the field";
  check.text = "by calibrations and masks";
  if (facts.coverage.uncovered_mm.size() > facts.coverage.out_of_reach_mm.size()) {
    check.state = CheckState::kWarn;
    check.text = "until all cameras run";
  }
  return check;
}

}  // namespace

void report_verdict(const VerdictFacts& facts, HealthReport& report) {
  for (const auto part : {report_lost, report_none, report_ball, report_roster, report_allowed,
                          report_doubles, report_size, report_lines, report_overlaps, report_coverage})
    part(facts, report);
  for (const auto check : {check_robots, check_agreement, check_coverage})
    report.checks.push_back(check(facts));
}

}  // namespace sslv
