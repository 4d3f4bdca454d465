// SPDX-License-Identifier: Apache-2.0
#include "services/verdict/sightings.h"

#include <algorithm>
#include <cmath>

namespace sslv {
namespace {

/// Two cameras' frames are compared if they are at most this far apart in time, after compensating the
/// robot's motion in between.
constexpr double kOneMoment_s = 0.1;
/// Detections up to this age are current.
constexpr double kNow_s = 1;
/// Two robots touch at 180 mm. Two detections of one id farther apart than this are two robots, not a
/// calibration error.
constexpr double kTwoRobotsMm = 400;
/// An id in two places is reported if it is seen kMinDoubles times within kDoubles_s. This excludes robots
/// that are carried and single wrong ids.
constexpr std::size_t kMinDoubles = 5;
constexpr double kDoubles_s = 3;
/// Two cameras are compared over the last kApart_s or, if few robots pass, over up to kApartAtMost_s.
constexpr double kApart_s = 4, kApartAtMost_s = 20;
constexpr std::size_t kMinApart = 8, kMaxApart = 400;
/// The position of faster robots at one moment is not accurate to a few millimetres.
constexpr double kMaxSpeedMm_s = 1500;

void count_at_once(std::vector<LostRobot>& lost) {
  for (const LostRobot& last : lost) {
    const auto is_of_these = [&](const LostRobot& one) {
      return one.gone_s >= last.gone_s && one.gone_s <= last.gone_s + Sightings::kAtOnce_s;
    };
    const auto count = static_cast<std::size_t>(std::ranges::count_if(lost, is_of_these));
    for (LostRobot& one : lost) {
      if (is_of_these(one)) one.at_once = std::max(one.at_once, count);
    }
  }
}

}  // namespace

bool SubstitutionAreas::hold(Team team, const Eigen::Vector2d& robot_mm) const {
  for (const bool positive_x : {false, true}) {
    const bool is_own = !blue_at_positive_x || (team == Team::kBlue) == (positive_x == *blue_at_positive_x);
    if (is_own && waits_behind_goal(field, positive_x, robot_mm.x(), robot_mm.y())) return true;
  }
  return false;
}

void Sightings::add(int camera_id, double t_s, double t_capture_s, std::span<const Robot> robots,
                    std::span<const Ball> balls, std::span<const Robot> second_robots) {
  for (std::size_t i = 0; i < robots.size(); ++i) {
    const Robot& robot = robots[i];
    const Identity identity{robot.team, robot.id};
    Robots& known = robots_[identity];
    Seen seen{t_capture_s, {robot.x_mm, robot.y_mm}, {0, 0}};
    add_doubles(camera_id, t_s, robots.subspan(i, 1), robots.first(i));
    if (const auto before = known.by_camera.find(camera_id); before != known.by_camera.end()) {
      const double passed_s = t_capture_s - before->second.t_capture_s;
      if (passed_s > 0 && passed_s < kGap_s)
        seen.velocity_mm_s = (seen.place_mm - before->second.place_mm) / passed_s;
    }
    compare(identity, known, camera_id, t_s, seen);
    known.by_camera[camera_id] = seen;
    const double gone_s = t_s - known.last_s.value_or(-1e9);
    if (gone_s > kGap_s) known.since_s = t_s;
    // A robot that reappears after it was given up counts as new, or as still lost, until it is seen
    // steadily.
    if (gone_s > kExpected_s) {
      if (known.is_steady && !known.was_handled) known.lost_s = known.last_s;
      if (!known.lost_s) known.came_s = t_s;
      known.is_steady = false;
    }
    known.last_s = t_s;
    known.last_camera = camera_id;
    known.was_handled = are_handled_;
    known.place_mm = seen.place_mm;
    if (t_s - known.since_s >= kSteady_s) {
      known.is_steady = true;
      known.lost_s.reset();
    }
    while (!known.doubles.empty() && t_s - known.doubles.front().first > kDoubles_s)
      known.doubles.pop_front();
  }
  add_doubles(camera_id, t_s, second_robots, robots);
  if (balls.empty()) return;
  const double gone_s = t_s - ball_s_.value_or(-1e9);
  if (gone_s > kGap_s) ball_since_s_ = t_s;
  if (gone_s > kExpected_s) ball_is_steady_ = false;
  ball_s_ = t_s;
  ball_camera_ = camera_id;
  if (t_s - ball_since_s_ >= kSteady_s) ball_is_steady_ = true;
}

/// Records ids that occur twice in one image.
void Sightings::add_doubles(int camera_id, double t_s, std::span<const Robot> robots,
                            std::span<const Robot> others) {
  for (const Robot& robot : robots) {
    for (const Robot& other : others) {
      if (other.team != robot.team || other.id != robot.id) continue;
      robots_[{robot.team, robot.id}].doubles.push_back(
          {t_s,
           {robot.team,
            robot.id,
            {camera_id, camera_id},
            {Eigen::Vector2d(other.x_mm, other.y_mm), Eigen::Vector2d(robot.x_mm, robot.y_mm)}}});
    }
  }
}

void Sightings::compare(const Identity& identity, Robots& robots, int camera_id, double t_s,
                        const Seen& seen) {
  for (const auto& [other_id, other] : robots.by_camera) {
    const double passed_s = seen.t_capture_s - other.t_capture_s;
    if (other_id == camera_id || std::abs(passed_s) > kOneMoment_s) continue;
    const Eigen::Vector2d there = other.place_mm + other.velocity_mm_s * passed_s;
    const double apart_mm = (there - seen.place_mm).norm();
    if (apart_mm > kTwoRobotsMm) {
      robots.doubles.push_back(
          {t_s, {identity.first, identity.second, {other_id, camera_id}, {there, seen.place_mm}}});
      continue;
    }
    if (seen.velocity_mm_s.norm() > kMaxSpeedMm_s) continue;
    auto& samples = apart_[std::minmax(camera_id, other_id)].samples;
    samples.emplace_back(t_s, apart_mm);
    while (samples.size() > kMaxApart || t_s - samples.front().first > kApartAtMost_s) samples.pop_front();
  }
}

void Sightings::forget(int camera_id) {
  for (auto& [identity, robots] : robots_) {
    robots.by_camera.erase(camera_id);
    std::erase_if(robots.doubles, [&](const auto& one) {
      return one.second.cameras[0] == camera_id || one.second.cameras[1] == camera_id;
    });
  }
  std::erase_if(
      apart_, [&](const auto& one) { return one.first.first == camera_id || one.first.second == camera_id; });
}

void Sightings::expect_nothing_of(int camera_id) {
  forget(camera_id);
  for (auto& [identity, robots] : robots_) {
    if (robots.last_camera != camera_id) continue;
    robots.is_steady = false;
    robots.lost_s.reset();
  }
  if (ball_camera_ == camera_id) ball_is_steady_ = false;
}

/// Robots stay expected if many disappeared at once. Drops them when enough other robots of their team have
/// appeared since, so that fewer than kMany are missing.
void Sightings::drop_replaced(std::vector<LostRobot>& lost, double t_s) const {
  for (const Team team : {Team::kYellow, Team::kBlue}) {
    const auto lasts = [&](const LostRobot& robot) {
      return robot.team == team && robot.gone_s > kExpected_s;
    };
    double longest_s = 0;
    for (const LostRobot& robot : lost) {
      if (lasts(robot)) longest_s = std::max(longest_s, robot.gone_s);
    }
    const auto came = std::ranges::count_if(robots_, [&](const auto& one) {
      const auto& [identity, robots] = one;
      return identity.first == team && t_s - *robots.last_s <= kNow_s && t_s - robots.came_s < longest_s;
    });
    const auto went = std::ranges::count_if(lost, lasts);
    if (went - came < static_cast<std::ptrdiff_t>(kMany)) std::erase_if(lost, lasts);
  }
}

FieldSeen Sightings::now(double t_s, std::optional<double> match_since_s,
                         const std::optional<SubstitutionAreas>& areas) const {
  FieldSeen out;
  for (const auto& [identity, robots] : robots_) {
    const double gone_s = t_s - *robots.last_s;
    const auto team = static_cast<std::size_t>(identity.first);
    auto& team_gone_s = out.team_gone_s[team];
    team_gone_s = std::min(team_gone_s.value_or(gone_s), gone_s);
    const bool waits = areas && areas->hold(identity.first, robots.place_mm);
    if (gone_s <= kNow_s) {
      out.ids[team].push_back(identity.second);
      if (waits) out.waiting[team].push_back(identity.second);
    } else if (waits) {
      // Not lost: its team may have taken the robot away.
    } else if (robots.is_steady && gone_s <= kExpected_s) {
      out.lost.push_back({identity.first, identity.second, gone_s, robots.place_mm, 1, robots.was_handled});
    } else if (match_since_s) {
      const bool lasts = robots.is_steady && !robots.was_handled;
      const auto lost_s = robots.lost_s ? robots.lost_s : lasts ? robots.last_s : std::nullopt;
      if (lost_s && *lost_s >= *match_since_s)
        out.lost.push_back({identity.first, identity.second, t_s - *lost_s, robots.place_mm});
    }
    const auto recent = std::count_if(robots.doubles.begin(), robots.doubles.end(),
                                      [&](const auto& one) { return t_s - one.first <= kDoubles_s; });
    if (static_cast<std::size_t>(recent) >= kMinDoubles) out.doubles.push_back(robots.doubles.back().second);
  }
  count_at_once(out.lost);
  std::erase_if(out.lost,
                [](const LostRobot& robot) { return robot.gone_s > kExpected_s && robot.at_once < kMany; });
  drop_replaced(out.lost, t_s);
  for (const auto& [cameras, apart] : apart_) {
    std::vector<double> distances;
    for (auto one = apart.samples.rbegin(); one != apart.samples.rend(); ++one) {
      const double age_s = t_s - one->first;
      if (age_s > kApartAtMost_s || (age_s > kApart_s && distances.size() >= kMinApart)) break;
      distances.push_back(one->second);
    }
    if (distances.size() < kMinApart) continue;
    const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
    std::nth_element(distances.begin(), middle, distances.end());
    out.overlaps.push_back({{cameras.first, cameras.second}, *middle, distances.size()});
  }
  const double ball_gone_s = t_s - ball_s_.value_or(-1e9);
  out.ball = ball_gone_s <= kNow_s;
  if (!out.ball && ball_is_steady_ && ball_gone_s <= kExpected_s) out.ball_gone_s = ball_gone_s;
  return out;
}

}  // namespace sslv
