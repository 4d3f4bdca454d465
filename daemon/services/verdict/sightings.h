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

/// A robot that was seen steadily and is no longer seen.
struct LostRobot {
  Team team;
  int id;
  double gone_s;  // time since it was last seen
  Eigen::Vector2d place_mm;
  /// Number of lost robots, including this one, that disappeared within the same few seconds.
  std::size_t at_once = 1;
  bool was_handled = false;  // when it disappeared, people were allowed to take robots off the field
};

/// One id in two places at the same time.
struct DoubleRobot {
  Team team;
  int id;
  std::array<int, 2> cameras;
  std::array<Eigen::Vector2d, 2> places_mm;
};

/// Distance between the positions at which two cameras see the same robots.
struct Overlap {
  std::array<int, 2> cameras;
  double apart_mm = 0;  // median
  std::size_t samples = 0;
};

/// Areas behind a team's own goal in which its robots wait for substitution. These robots do not count as on
/// the field.
struct SubstitutionAreas {
  const FieldSize& field;
  std::optional<bool> blue_at_positive_x{};  // none: unknown; each goal may then be either team's

  bool hold(Team team, const Eigen::Vector2d& robot_mm) const;
};

/// Recent detections of all cameras together.
struct FieldSeen {
  std::array<std::vector<int>, 2> ids;                 // by Team: ids of the robots currently seen, ascending
  std::array<std::vector<int>, 2> waiting;             // by Team: the ids in their team's substitution area
  std::array<std::optional<double>, 2> team_gone_s{};  // by Team: time since its last detection; none: never
  std::vector<LostRobot> lost;                         // lost within the last minute; in a match: see now()
  std::vector<DoubleRobot> doubles;
  std::vector<Overlap> overlaps;
  bool ball = false;                    // a ball is seen now
  std::optional<double> ball_gone_s{};  // time since a steadily seen ball disappeared; none after a minute

  std::size_t on_field(Team team) const {
    const auto index = static_cast<std::size_t>(team);
    return ids[index].size() - waiting[index].size();
  }
};

/// History of the cameras' detections. Each call of add() is one frame of one camera. Not thread-safe.
class Sightings {
 public:
  /// `t_s`: monotonic time of the call. `t_capture_s`: capture time of the image, on the cameras' clock.
  /// `second_robots`: robots in the image that have the id of one of `robots`.
  void add(int camera_id, double t_s, double t_capture_s, std::span<const Robot> robots,
           std::span<const Ball> balls, std::span<const Robot> second_robots = {});
  /// This camera's view has changed: its earlier detections are no longer compared. The robots it saw are
  /// still expected.
  void forget(int camera_id);
  /// This camera was removed or replaced: like forget(), and the robots that it saw last are no longer
  /// expected.
  void expect_nothing_of(int camera_id);
  /// Whether people may take robots off the field from now on, as in a HALT or a timeout of a match.
  void robots_are_handled(bool are) { are_handled_ = are; }
  /// State at a monotonic time. `match_since_s`: since when a match runs, on the same clock. If kMany robots
  /// were lost at once during the match, and were not handled, they stay expected until they, or other robots
  /// of their team, are seen. Robots that waited in `areas` are not expected: people may take them from there
  /// at any time.
  FieldSeen now(double t_s, std::optional<double> match_since_s = {},
                const std::optional<SubstitutionAreas>& areas = {}) const;

  /// A robot seen for kSteady_s, without a gap above kGap_s, is expected to stay.
  static constexpr double kSteady_s = 5, kGap_s = 1;
  /// A steady robot is expected until this long after it was last seen.
  static constexpr double kExpected_s = 60;
  /// Nobody takes this many robots off the field within kAtOnce_s.
  static constexpr std::size_t kMany = 3;
  static constexpr double kAtOnce_s = 5;

 private:
  using Identity = std::pair<Team, int>;
  struct Seen {
    double t_capture_s;
    Eigen::Vector2d place_mm, velocity_mm_s;
  };
  struct Robots {
    std::map<int, Seen> by_camera;   // newest detection of each camera
    std::optional<double> last_s;    // when it was last seen
    int last_camera = -1;            // camera that saw it last
    bool was_handled = false;        // at last_s, people were allowed to take robots off the field
    std::optional<double> lost_s{};  // last_s before it was given up; reset when it is steady again
    double came_s = 0;               // when it was first seen, or reappeared without being missed
    double since_s = 0;              // start of the current streak
    bool is_steady = false;          // it was seen steadily, and is expected
    Eigen::Vector2d place_mm{0, 0};  // newest position
    std::deque<std::pair<double, DoubleRobot>> doubles;  // with the times when they were seen
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
  int ball_camera_ = -1;         // camera that saw the ball last
  double ball_since_s_ = 0;      // start of the current streak
  bool ball_is_steady_ = false;  // it was seen steadily
  bool are_handled_ = false;
};

}  // namespace sslv
