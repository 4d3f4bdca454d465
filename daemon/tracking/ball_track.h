// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tracking/ball_flight.h"
#include "tracking/ball_motion.h"
#include "tracking/camera_differences.h"
#include "tracking/kick_fit.h"
#include "tracking/robot_tracks.h"
#include "tracking/sightings.h"

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace sslv {

/// One ball: free (rolling or sliding), held by a robot, or flying. Measurements outside the gate are
/// collected in branches (possible new trajectories) until two measurements together show a kick or
/// deflection and its time.
class BallTrack {
 public:
  /// Starts a track from the newest of `sightings` measurements.
  BallTrack(const BallModel& model, const BallObservation& newest, const Eigen::Vector2d& velocity_mm_s,
            int sightings);

  /// Takes effect from the next prediction.
  void set_model(const BallModel& model) { model_ = model; }

  enum class Saw { kNothing, kBall, kTurn };
  /// Processes the balls of one image. kBall: a ball is inside the gate. kTurn: two or three measurements
  /// show that the ball was kicked or deflected; `before` is then the track without this turn, which may
  /// still be the true track.
  Saw add(const std::vector<BallObservation>& seen, const RobotTracks& robots,
          std::optional<BallTrack>& before);
  /// Whether the measurement is inside the gate.
  bool explains(const BallObservation& sighting, const RobotTracks& robots) const;
  TrackedBall at(double t_s, const RobotTracks& robots) const;
  double seen_s() const { return seen_s_; }
  Eigen::Vector2d seen_mm() const { return seen_mm_; }
  const std::optional<TrackedKick>& kick() const { return kick_; }
  /// Number of measurements since the track began or turned.
  int sightings() const { return sightings_; }
  /// Whether at most a third of these measurements had a large innovation.
  bool is_steady() const { return 3 * surprises_ <= sightings_; }
  bool has_no_surprises() const { return surprises_ == 0; }
  /// Time of the last measurement that showed the ball moving.
  double moved_s() const { return moved_s_; }
  /// Whether the ball is well above the floor.
  bool is_in_the_air(double t_s) const;
  /// Whether the ball was unseen for so long that it may be anywhere.
  bool is_gone(double t_s) const;
  /// Whether the ball is faster than any legal ball.
  bool is_too_fast() const;
  /// False: a filter state is not finite, so the track is unusable.
  bool is_finite() const;

 private:
  static constexpr double kApart_s = 0.003;  // shortest time between measurements for a velocity

  enum class Phase { kFree, kHeld, kFlying };
  using Vector5 = Eigen::Matrix<double, 5, 1>;
  using Matrix5 = Eigen::Matrix<double, 5, 5>;
  /// Filter of a ball on the floor. State: position, velocity, deceleration.
  struct Flat {
    double t_s = 0;
    Vector5 state = Vector5::Zero();
    Matrix5 cov = Matrix5::Zero();
    bool slides = false;
    double began_mm_s = 0;  // speed when sliding began

    void predict(double to_s, const BallModel& model);
    Eigen::Vector2d place() const { return state.head<2>(); }
    Eigen::Vector2d velocity() const { return state.segment<2>(2); }
  };

  /// Measurements outside the gate that may be the ball's new trajectory.
  struct Branch {
    std::array<BallObservation, 8> seen;
    std::size_t count = 0;

    const BallObservation& first() const { return seen[0]; }
    const BallObservation& last() const { return seen[count - 1]; }
    void add(const BallObservation& one);
    double passed_s() const { return last().t_s - first().t_s; }
    Eigen::Vector2d velocity() const { return (last().place_mm - first().place_mm) / passed_s(); }
    /// Stationary: probably clutter.
    bool lies() const;
    /// Consistent with free motion.
    bool is_straight() const;
  };

  /// Intersection of the old and the new trajectory.
  struct Meeting {
    double t_s, off_mm;  // time and distance of the closest approach
    Eigen::Vector2d place_mm, before_mm_s;
  };

  void roll(const BallObservation& at, const Eigen::Vector2d& velocity_mm_s, bool slides, double began_mm_s);
  Eigen::Vector2d held_at(double t_s, const RobotTracks& robots) const;
  Eigen::Vector2d seen_from(const Eigen::Vector3d& camera_mm, double t_s, const RobotTracks& robots) const;
  double gate_mm(double t_s) const;
  void accept(const BallObservation& sighting, const RobotTracks& robots);
  void correct(const BallObservation& sighting);
  void may_be_held(const BallObservation& sighting, const RobotTracks& robots);
  Saw surprise(const std::vector<BallObservation>& seen, const Eigen::Vector2d& expected_mm,
               const RobotTracks& robots, std::optional<BallTrack>& before);
  void announce(const BallObservation& now, const RobotTracks& robots);
  bool was_on_its_way(const BallObservation& now, const RobotTracks& robots) const;
  static bool tells_a_way(const Branch& branch, const BallObservation& now);
  static bool pushes(const TrackedRobot& robot, const Eigen::Vector2d& ball_mm, const Eigen::Vector2d& before,
                     const Eigen::Vector2d& after);
  Meeting meeting_of(const Branch& branch, const RobotTracks& robots) const;
  void follow(const Branch& branch);
  Saw explain(const Branch& branch, const RobotTracks& robots);
  void turn_in_the_air(const Branch& branch, double event_s);
  /// Whether the ball is flying so fast up or down that it bounces, or has just bounced.
  bool bounces(double t_s) const;
  void forget_branches();
  const Branch* reappears(double t_s, const RobotTracks& robots) const;
  bool where_it_reappears(const Branch& branch, double t_s, BallState& out) const;
  void begin_kick(const TrackedRobot& robot, const Eigen::Vector2d& velocity_mm_s, bool is_new);
  void fly(const BallFlight& flight);
  void may_fly(double t_s, const RobotTracks& robots);
  BallFlight flight_at(double t_s) const;
  static ShotPoint point_of(const BallObservation& one);
  void add_point(const BallObservation& sighting);
  void fit_shot();

  BallModel model_;
  Phase phase_ = Phase::kFree;
  double seen_s_;
  Eigen::Vector2d seen_mm_;  // position at seen_s_
  int sightings_ = 1;
  Eigen::Vector2d began_mm_;
  bool has_moved_ = false;  // has moved away from began_mm_
  double moved_s_ = 0;
  Flat flat_;
  CameraDifferences<Eigen::Vector3d, 4> differences_{6, false};
  RobotName holder_;
  Eigen::Vector2d held_mm_{0, 0};  // offset from the holder's centre: ahead, left
  double held_var_mm2_ = 0;        // variance of the ball's shaking at the holder
  BallObservation held_seen_{};
  /// The robot that a free ball was next to, and where, seen from the robot: ahead, left.
  struct Beside {
    RobotName robot;
    Eigen::Vector2d offset_mm;
  };
  std::optional<Beside> beside_;
  bool is_announced_ = false;  // a kick was announced from one measurement
  int held_count_ = 0;
  double alone_until_s_ = 0;  // no robot can hold the ball before this time
  bool left_holder_ = false;  // the ball left its holder, apparently without a kick
  int surprises_ = 0;         // large innovations since roll()
  std::array<Branch, 4> branches_;
  // State since the last kick or turn.
  double event_s_ = -9;
  Eigen::Vector2d event_mm_{0, 0}, before_mm_s_{0, 0};  // before_mm_s_: velocity before event_s_
  bool is_kick_ = false, is_chip_ = false;
  std::array<ShotPoint, kMaxShotPoints> points_;
  std::size_t point_count_ = 0;
  BallShot chip_;      // trajectory while flying
  BallFlight flight_;  // filter while flying without a kick fit
  ShotPrior::Robot kicker_;
  std::optional<TrackedKick> kick_;
};

}  // namespace sslv
