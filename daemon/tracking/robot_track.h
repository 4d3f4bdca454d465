// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tracking/camera_differences.h"
#include "tracking/sightings.h"

#include <Eigen/Core>

namespace sslv {

/// One robot, from the sightings of all cameras: a Kalman filter of place, velocity and acceleration, which
/// allows for a manoeuvre when it is surprised, and beside it one of a robot that stands.
class RobotTrack {
 public:
  RobotTrack(const RobotObservation& first);
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;

  /// What one sighting made of it, and what a smoother needs to go back over it.
  struct Step {
    double t_s = 0;
    bool is_first = true;
    Vector6 state, predicted;  // place, velocity, acceleration; with and without this sighting
    Matrix6 back;              // what one more of this step's state tells of the state before
    Eigen::Vector3d angle, predicted_angle;
    Eigen::Matrix3d angle_back;
    Eigen::Vector2d stands_mm;
    double stands_share, place_sigma_mm;

    /// Near that time.
    TrackedRobot robot_at(const RobotName& name, double t_s) const;
  };

  struct Circumstances {
    bool touches = false;     // another one, which may push it
    bool stays_here = false;  // however often it is seen elsewhere
  };
  /// False: this cannot be the same robot. `step`: gets what became of it; null: nobody wants that.
  bool add(const RobotObservation& sighting, const Circumstances& now, Step* step = nullptr);
  TrackedRobot at(double t_s) const;
  /// What is known of it by now, as if it had just begun.
  Step last_step() const;
  /// How far it can be from where it is expected then, however hard it has accelerated lately.
  double unforeseen_mm(double t_s) const;

  double seen_s() const { return seen_s_; }
  /// Between two sightings, lately.
  double interval_s() const { return interval_s_; }
  /// Not seen for so long, a robot is no longer on the field.
  static constexpr double kGone_s = 0.5;
  int sightings() const { return sightings_; }
  /// False: the filter is of no use and has to be reset.
  bool is_finite() const;
  /// Whether it is more than a pattern misread, or something that looks like one.
  bool is_sure() const;
  double height_mm() const { return height_mm_; }
  /// Both without looking ahead.
  Eigen::Vector2d place_mm() const { return state_.head<2>(); }
  Eigen::Vector2d velocity_mm_s() const { return state_.segment<2>(2); }

 private:
  void begin(const RobotObservation& first);
  /// Whether a second sighting may be of the same robot as the first.
  bool goes_on(const RobotObservation& second) const;
  /// Whether it was seen there again and again, and nowhere else.
  bool is_now_at(const RobotObservation& sighting);
  void is_seen_here(const RobotObservation& sighting);
  void predict(double t_s);
  /// Gives what was uncertain before.
  Eigen::Matrix3d turn(const RobotObservation& sighting);
  void stand(const RobotObservation& sighting, const Eigen::Matrix2d& noise, double moving_likelihood);

  RobotName name_;
  double t_s_ = 0, seen_s_ = 0;
  double interval_s_ = 0.02;
  int sightings_ = 0;
  double second_after_s_ = 0;  // the second sighting, after the first
  double height_mm_ = 0;       // of its pattern
  Vector6 state_;              // place, velocity, acceleration
  Matrix6 cov_;
  Eigen::Vector3d angle_;  // orientation, turn, its acceleration
  Eigen::Matrix3d angle_cov_;
  /// How much more noise there is than the fits say: vibration, which no model of motion explains.
  double noise_factor_ = 1, angle_noise_factor_ = 1;
  // A robot that stands, and how likely it does.
  Eigen::Vector2d stands_mm_;
  double stands_var_mm2_ = 0, stands_share_ = 0, stood_s_ = 0;
  CameraDifferences<int, 8> differences_{8, true};
  /// Sightings that cannot be this robot, but may be where it is now.
  Eigen::Vector2d elsewhere_mm_{0, 0};
  double elsewhere_s_ = 0;
  int elsewhere_ = 0;
  /// Where another robot with the same id was seen.
  Eigen::Vector2d other_mm_{0, 0};
  double other_s_ = -1e9;
};

}  // namespace sslv
