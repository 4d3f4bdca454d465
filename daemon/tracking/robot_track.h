// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tracking/camera_differences.h"
#include "tracking/sightings.h"

#include <Eigen/Core>

namespace sslv {

/// Tracks one robot from all cameras' measurements: a Kalman filter of position, velocity and acceleration,
/// which assumes a manoeuvre when the innovation is large, and the hypothesis that the robot stands still.
class RobotTrack {
 public:
  RobotTrack(const RobotObservation& first);
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;

  /// State after one measurement, and the data that a smoother needs for its backward pass.
  struct Step {
    double t_s = 0;
    bool is_first = true;
    Vector6 state, predicted;  // position, velocity, acceleration; after and before the update
    Matrix6 back;              // smoother gain: from this step's state to the previous state
    Eigen::Vector3d angle, predicted_angle;
    Eigen::Matrix3d angle_back;
    Eigen::Vector2d stands_mm;
    double stands_share, place_sigma_mm;

    /// The robot, extrapolated to a time near this step's; its visibility is not set.
    TrackedRobot robot_at(const RobotName& name, double t_s) const;
  };

  struct Circumstances {
    bool touches = false;     // touches another robot, which may push it
    bool stays_here = false;  // does not restart elsewhere, even after repeated measurements there
  };
  /// Returns false if the measurement cannot be of this robot. Else writes the result to `step`, unless
  /// `step` is null.
  bool add(const RobotObservation& sighting, const Circumstances& now, Step* step = nullptr);
  TrackedRobot at(double t_s) const;
  /// Current state, as a track's first step.
  Step last_step() const;
  /// Largest prediction error at `t_s` (mm), assuming maximum acceleration since the last measurements.
  double unforeseen_mm(double t_s) const;

  double seen_s() const { return seen_s_; }
  /// Recent mean interval between measurements.
  double interval_s() const { return interval_s_; }
  /// A robot that was not seen for this long is no longer on the field.
  static constexpr double kGone_s = 0.5;
  int sightings() const { return sightings_; }
  /// Whether all filter states are finite. If not, the track must be reset.
  bool is_finite() const;
  /// False while the robot may be a misread pattern, or clutter that looks like a pattern.
  bool is_sure() const;
  double height_mm() const { return height_mm_; }
  /// Position and velocity at the last measurement, not predicted.
  Eigen::Vector2d place_mm() const { return state_.head<2>(); }
  Eigen::Vector2d velocity_mm_s() const { return state_.segment<2>(2); }

 private:
  void begin(const RobotObservation& first);
  /// Whether a second measurement may belong to the same robot as the first one.
  bool goes_on(const RobotObservation& second) const;
  /// Whether the robot was measured repeatedly at the position of `sighting`, and no longer at its old
  /// position.
  bool is_now_at(const RobotObservation& sighting);
  void is_seen_here(const RobotObservation& sighting);
  void predict(double t_s);
  void learn_jerk(const Eigen::Vector2d& innovation_sigmas);
  /// Updates the orientation; returns its covariance before the update, including a manoeuvre's.
  Eigen::Matrix3d turn(const RobotObservation& sighting);
  void stand(const RobotObservation& sighting, const Eigen::Matrix2d& noise, double moving_likelihood);

  RobotName name_;
  double t_s_ = 0, seen_s_ = 0;
  double interval_s_ = 0.02;
  int sightings_ = 0;
  double second_after_s_ = 0;  // time from the first to the second measurement
  double height_mm_ = 0;       // height of the robot's pattern
  Vector6 state_;              // position, velocity, acceleration
  Matrix6 cov_;
  Eigen::Vector3d angle_;  // orientation, turn rate, turn acceleration
  Eigen::Matrix3d angle_cov_;
  /// Factors on the variances that the fits report. They account for vibration, which no motion model
  /// explains.
  double noise_factor_ = 1, angle_noise_factor_ = 1;
  /// Factor on the noise of the acceleration: robots differ in how suddenly they start and stop.
  double jerk_factor_ = 1;
  Eigen::Vector2d innovation_sigmas_{0, 0};  // the last one, in sigmas
  // The hypothesis that the robot stands still, and its probability.
  Eigen::Vector2d stands_mm_;
  double stands_var_mm2_ = 0, stands_share_ = 0, stood_s_ = 0;
  CameraDifferences<int, 8> differences_{8, true};
  /// Position, time and number of successive measurements outside the gate: the robot may be there now.
  Eigen::Vector2d elsewhere_mm_{0, 0};
  double elsewhere_s_ = 0;
  int elsewhere_ = 0;
  /// Position and time at which another robot with the same id was seen.
  Eigen::Vector2d other_mm_{0, 0};
  double other_s_ = -1e9;
};

}  // namespace sslv
