// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rival.h"

#include <array>
#include <deque>
#include <map>
#include <vector>

namespace sslv::worlds {

/// The league's usual tracker: a constant-velocity filter per object and camera, merged by health. It does
/// not estimate camera errors, and compensates latency only with the velocity. Written for comparison, from
/// published knowledge (docs/measured/tracking.md).
class Incumbent final : public Rival {
 public:
  void add(const WorldImage& image) override;
  std::optional<TrackedRobot> robot(const RobotName& name, double t_s) override;
  std::optional<TrackedBall> ball(double t_s) override;
  std::optional<TrackedKick> kick() const override { return kick_; }

 private:
  /// Filter of one axis.
  struct Axis {
    void begin(double place, double variance, double error, double noise, double t_s, double velocity);
    void predict(double t_s);
    void correct(double place);
    double at(double then_s) const { return place + velocity * (then_s - t_s); }

    double place = 0, velocity = 0, t_s = 0;
    double place_var = 0, cross_var = 0, velocity_var = 0;
    double model_error = 0, noise_var = 0;
  };
  struct RobotFilter {
    Axis x, y, angle;
    double seen_s = 0;
    int health = 2;
  };
  struct BallFilter {
    Axis x, y;
    int camera = 0, health = 2, sightings = 0;
    double seen_s = 0;
    Eigen::Vector2d seen_mm{0, 0};
  };
  struct Merged {
    Eigen::Vector2d seen_mm{0, 0}, place_mm{0, 0}, velocity_mm_s{0, 0};
    double seen_s = 0;
  };
  struct Record {
    double t_s;
    Eigen::Vector2d ball_mm;
    std::vector<TrackedRobot> robots;
  };

  void add_robot(int camera, double t_s, const RobotSighting& sighting);
  void add_ball(int camera, double t_s, const BallSighting& sighting);
  std::optional<Merged> merged_ball(double t_s);
  void tick(double now_s);
  void look_for_kick();
  void fit_kick();

  std::map<RobotName, std::map<int, RobotFilter>> robots_;
  std::vector<BallFilter> balls_;
  double newest_s_ = 0, tick_s_ = 0, recorded_s_ = -1, kicked_s_ = -9;
  Eigen::Vector2d last_ball_mm_{0, 0};
  std::deque<Record> records_;
  std::deque<std::pair<double, Eigen::Vector2d>> since_kick_;
  std::optional<TrackedKick> kick_;
};

}  // namespace sslv::worlds
