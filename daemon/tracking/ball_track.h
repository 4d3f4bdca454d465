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

/// One ball: rolls or slides, is held by a robot, or flies. What no phase explains is kept apart until two
/// sightings say together what happened, and when.
class BallTrack {
 public:
  /// From some sightings, of which this is the newest.
  BallTrack(const BallModel& model, const BallObservation& newest, const Eigen::Vector2d& velocity_mm_s,
            int sightings);

  /// From now on.
  void set_model(const BallModel& model) { model_ = model; }

  enum class Saw { kNothing, kBall, kTurn };
  /// What one image shows of balls. kTurn: it was kicked or turned away, as two or three sightings tell; what
  /// went before may still be true, and is put down.
  Saw add(const std::vector<BallObservation>& seen, const RobotTracks& robots,
          std::optional<BallTrack>& before);
  /// Whether this sighting is where it is expected.
  bool explains(const BallObservation& sighting, const RobotTracks& robots) const;
  TrackedBall at(double t_s, const RobotTracks& robots) const;
  double seen_s() const { return seen_s_; }
  Eigen::Vector2d seen_mm() const { return seen_mm_; }
  const std::optional<TrackedKick>& kick() const { return kick_; }
  /// Sightings since it began or turned.
  int sightings() const { return sightings_; }
  /// Whether it goes its way without surprises.
  bool is_steady() const { return 3 * surprises_ <= sightings_; }
  /// When it last moved, as far as was seen.
  double moved_s() const { return moved_s_; }
  /// Well above the floor.
  bool is_in_the_air(double t_s) const;
  /// It may be anywhere now.
  bool is_gone(double t_s) const;
  /// Of no ball of the league.
  bool is_too_fast() const;
  /// False: its filters are of no use.
  bool is_finite() const;

 private:
  static constexpr double kApart_s = 0.003;  // between sightings that tell a velocity

  enum class Phase { kFree, kHeld, kFlying };
  using Vector5 = Eigen::Matrix<double, 5, 1>;
  using Matrix5 = Eigen::Matrix<double, 5, 5>;
  /// On the floor: place, velocity, deceleration.
  struct Flat {
    double t_s = 0;
    Vector5 state = Vector5::Zero();
    Matrix5 cov = Matrix5::Zero();
    bool slides = false;
    double began_mm_s = 0;  // to slide

    void predict(double to_s, const BallModel& model);
    Eigen::Vector2d place() const { return state.head<2>(); }
    Eigen::Vector2d velocity() const { return state.segment<2>(2); }
  };

  /// Sightings that do not fit, but may be what it has turned to.
  struct Branch {
    std::array<BallObservation, 8> seen;
    std::size_t count = 0;

    const BallObservation& first() const { return seen[0]; }
    const BallObservation& last() const { return seen[count - 1]; }
    void add(const BallObservation& one);
    double passed_s() const { return last().t_s - first().t_s; }
    Eigen::Vector2d velocity() const { return (last().place_mm - first().place_mm) / passed_s(); }
    /// As something does that looks like a ball and is none.
    bool lies() const;
    /// As a ball goes that meets nothing.
    bool is_straight() const;
  };

  /// Of two ways.
  struct Meeting {
    double t_s, off_mm;  // when, and by how much they miss each other
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
  void forget_branches();
  const Branch* reappears(double t_s) const;
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
  Eigen::Vector2d seen_mm_;  // the place then
  int sightings_ = 1;
  Eigen::Vector2d began_mm_;
  bool has_moved_ = false;  // away from there
  double moved_s_ = 0;
  Flat flat_;
  CameraDifferences<Eigen::Vector3d, 4> differences_{6, false};
  RobotName holder_;
  Eigen::Vector2d held_mm_{0, 0};  // ahead and left of the holder's centre
  double held_var_mm2_ = 0;        // how far it shakes there
  BallObservation held_seen_{};
  bool is_announced_ = false;  // that it was kicked, of one sighting
  int held_count_ = 0;
  double alone_until_s_ = 0;  // no robot can hold it before
  bool left_holder_ = false;  // and was not kicked, as it seems
  int surprises_ = 0;         // since it rolls
  std::array<Branch, 4> branches_;
  // Since the last kick or turn.
  double event_s_ = -9;
  Eigen::Vector2d event_mm_{0, 0}, before_mm_s_{0, 0};  // the velocity until then
  bool is_kick_ = false, is_chip_ = false;
  std::array<ShotPoint, kMaxShotPoints> points_;
  std::size_t point_count_ = 0;
  BallShot chip_;      // while it flies
  BallFlight flight_;  // likewise, unless it is a kick's
  ShotPrior::Robot kicker_;
  std::optional<TrackedKick> kick_;
};

}  // namespace sslv
