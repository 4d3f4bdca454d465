// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geometry/field.h"
#include "vision/detections.h"

#include <array>
#include <cstddef>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace sslv {

/// A robot that had been seen steadily and no longer is.
struct LostRobot {
  Team team;
  int id;
  double gone_s;  // since it was seen last
  Eigen::Vector2d place_mm;
  /// Of the lost ones, those that went within the same few seconds; itself among them.
  std::size_t at_once = 1;
  bool was_handled = false;  // it went while people may take robots off
};

/// One id in two places at the same time.
struct DoubleRobot {
  Team team;
  int id;
  std::array<int, 2> cameras;
  std::array<Eigen::Vector2d, 2> places_mm;
};

/// How far apart two cameras see the same robots.
struct Overlap {
  std::array<int, 2> cameras;
  double apart_mm = 0;  // median
  std::size_t samples = 0;
};

/// Where robots wait for their substitution, behind their own goal: they are not on the field.
struct SubstitutionAreas {
  const FieldSize& field;
  std::optional<bool> blue_at_positive_x{};  // whose goal is where; not known: either may be anybody's

  bool hold(Team team, const Eigen::Vector2d& robot_mm) const;
};

/// What all cameras together have seen lately.
struct FieldSeen {
  std::array<std::vector<int>, 2> ids;      // by Team: of the robots seen now, ascending
  std::array<std::vector<int>, 2> waiting;  // of them, those in their team's substitution area
  std::array<std::optional<double>, 2>
      team_gone_s{};            // by Team: since one of its robots was seen; none: never
  std::vector<LostRobot> lost;  // within the last minute; in a match: see now()
  std::vector<DoubleRobot> doubles;
  std::vector<Overlap> overlaps;
  bool ball = false;  // one is seen now
  std::optional<double>
      ball_gone_s{};  // since one was seen last that had been seen steadily; within a minute

  std::size_t on_field(Team team) const {
    const auto index = static_cast<std::size_t>(team);
    return ids[index].size() - waiting[index].size();
  }
};

/// Remembers what the cameras saw, look by look. A look is one frame of one camera. Not for several threads
/// at once.
class Sightings {
 public:
  /// `t_s` is the time of the look on a monotonic clock; `t_capture_s` that of the image, on the cameras'
  /// clock. `second_robots`: robots in the image that have the id of one of `robots`.
  void add(int camera_id, double t_s, double t_capture_s, std::span<const Robot> robots,
           std::span<const Ball> balls, std::span<const Robot> second_robots = {});
  /// This camera shows its part of the field otherwise from now on: nothing of before is compared with it.
  /// What it saw is still expected.
  void forget(int camera_id);
  /// This camera is gone, or another one took its place: what it saw last is no longer expected either.
  void expect_nothing_of(int camera_id);
  /// Whether people may take robots off the field from now on: in a HALT or a timeout of a match.
  void robots_are_handled(bool are) { are_handled_ = are; }
  /// At a time on the clock of the looks. `match_since_s`: since when a match runs, on the same clock. Many
  /// robots that were lost at once since then, and were not handled, are expected until they, or others of
  /// their team, are there. Robots that waited in `areas` are not expected: people take them from there at
  /// any time.
  FieldSeen now(double t_s, std::optional<double> match_since_s = {},
                const std::optional<SubstitutionAreas>& areas = {}) const;

  /// Seen for so long without a longer gap than kGap_s, a robot is expected to stay.
  static constexpr double kSteady_s = 5, kGap_s = 1;
  /// So long after it was seen last, a steady robot is expected no longer.
  static constexpr double kExpected_s = 60;
  /// Nobody takes so many robots off the field within kAtOnce_s.
  static constexpr std::size_t kMany = 3;
  static constexpr double kAtOnce_s = 5;

 private:
  using Identity = std::pair<Team, int>;
  struct Seen {
    double t_capture_s;
    Eigen::Vector2d place_mm, velocity_mm_s;
  };
  struct Robots {
    std::map<int, Seen> by_camera;   // each camera's newest
    std::optional<double> last_s;    // when it was seen
    int last_camera = -1;            // and by which camera
    bool was_handled = false;        // robots were, when it was seen
    std::optional<double> lost_s{};  // since it was expected no longer, until it is steady again
    double came_s = 0;               // seen for the first time, or when nobody missed it
    double since_s = 0;              // of the present streak
    bool is_steady = false;          // it once was, and is expected
    Eigen::Vector2d place_mm{0, 0};  // the newest
    std::deque<std::pair<double, DoubleRobot>> doubles;  // with their times
  };
  struct Apart {
    std::deque<std::pair<double, double>> samples;  // time, distance (mm)
  };

  void compare(const Identity& identity, Robots& robots, int camera_id, double t_s, const Seen& seen);
  void add_doubles(int camera_id, double t_s, std::span<const Robot> robots, std::span<const Robot> others);
  void drop_replaced(std::vector<LostRobot>& lost, double t_s) const;

  std::map<Identity, Robots> robots_;
  std::map<std::pair<int, int>, Apart> apart_;  // by the cameras' ids, the smaller first
  std::optional<double> ball_s_;
  int ball_camera_ = -1;         // that saw it then
  double ball_since_s_ = 0;      // of the present streak
  bool ball_is_steady_ = false;  // it once was
  bool are_handled_ = false;
};

}  // namespace sslv
