// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tracking/ball_motion.h"
#include "tracking/kick_fit.h"

#include <optional>
#include <span>

#include <Eigen/Core>

namespace sslv {

/// Kalman filter for a ball in the air, kicked or not: position and velocity, with gravity and bounces. Each
/// measurement gives a line of sight; the fall and the apparent size give the height.
struct BallFlight {
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;

  double t_s = 0;
  Vector6 state = Vector6::Zero();  // position, velocity (3D each)
  Matrix6 cov = Matrix6::Zero();
  double lower_sigmas = 0;  // decaying sum of height innovations; positive: the ball appears lower
  static constexpr double kUsualSurprise = 2;
  double surprise = kUsualSurprise;          // mean square of the last innovations of the place, in sigmas
  bool has_hopped = false, is_over = false;  // is_over: the ball rolls

  void predict(double to_s, const BallModel& model);
  void correct(const ShotPoint& seen, const BallModel& model);
  /// Whether the ball's apparent size has repeatedly indicated a lower height than predicted.
  bool is_doubtful() const;
  /// Whether no robot can have kicked the ball so high and fast.
  bool is_impossible(const BallModel& model) const;
  /// Upward speed with which the ball left the floor, if it came from there without hitting anything.
  double rose_mm_s(const BallModel& model) const;
  /// A deflection: resets the uncertainty of the horizontal motion; the vertical motion continues.
  void turn(double place_sigma_mm);
  /// The same trajectory as a BallShot.
  BallShot shot(const BallModel& model) const;

 private:
  void hop(const BallModel& model);
  double lands_after_s(const BallModel& model) const;
};

/// Detects the flight of a ball without history; the result is its state at the last point. Returns nothing
/// if the ball was on the floor or if the points do not allow a decision.
std::optional<BallFlight> find_flight(std::span<const ShotPoint> points, const BallModel& model);

}  // namespace sslv
