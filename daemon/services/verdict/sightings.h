// SPDX-License-Identifier: Apache-2.0
#pragma once

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

/// What all cameras together have seen lately.
struct FieldSeen {
  std::array<std::vector<int>, 2> ids;  // by Team: of the robots seen now, ascending
  std::vector<LostRobot> lost;          // within the last minute
  std::vector<DoubleRobot> doubles;
  std::vector<Overlap> overlaps;
  bool ball = false;  // one is seen now
  std::optional<double>
      ball_gone_s{};  // since one was seen last that had been seen steadily; within a minute
};

/// Remembers what the cameras saw, look by look. A look is one frame of one camera. Not for several threads
/// at once.
class Sightings {
 public:
  /// `t_s` is the time of the look on a monotonic clock; `t_capture_s` that of the image, on the cameras'
  /// clock.
  void add(int camera_id, double t_s, double t_capture_s, std::span<const Robot> robots,
           std::span<const Ball> balls);
  /// This camera shows something else from now on.
  void forget(int camera_id);
  /// At a time on the clock of the looks.
  FieldSeen now(double t_s) const;

  /// Seen for so long without a longer gap than kGap_s, a robot is expected to stay.
  static constexpr double kSteady_s = 5, kGap_s = 1;
  /// So long after it was seen last, a steady robot is expected no longer.
  static constexpr double kExpected_s = 60;

 private:
  using Identity = std::pair<Team, int>;
  struct Seen {
    double t_capture_s;
    Eigen::Vector2d place_mm, velocity_mm_s;
  };
  struct Robots {
    std::map<int, Seen> by_camera;                       // each camera's newest
    std::optional<double> last_s;                        // when it was seen
    double since_s = 0;                                  // of the present streak
    bool is_steady = false;                              // it once was
    Eigen::Vector2d place_mm{0, 0};                      // the newest
    std::deque<std::pair<double, DoubleRobot>> doubles;  // with their times
  };
  struct Apart {
    std::deque<std::pair<double, double>> samples;  // time, distance (mm)
  };

  void compare(const Identity& identity, Robots& robots, int camera_id, double t_s, const Seen& seen);

  std::map<Identity, Robots> robots_;
  std::map<std::pair<int, int>, Apart> apart_;  // by the cameras' ids, the smaller first
  std::optional<double> ball_s_;
  double ball_since_s_ = 0;      // of the present streak
  bool ball_is_steady_ = false;  // it once was
};

}  // namespace sslv
