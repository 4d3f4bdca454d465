// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tracking/ball_motion.h"
#include "tracking/kick_fit.h"

#include <optional>
#include <span>

#include <Eigen/Core>

namespace sslv {

/// A ball in the air, however it came there: a Kalman filter of place and velocity that falls and hops. Where
/// a camera sees it tells a line on which it is; how it falls, and how large it looks, tell how far up.
struct BallFlight {
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;

  double t_s = 0;
  Vector6 state = Vector6::Zero();  // place, velocity
  Matrix6 cov = Matrix6::Zero();
  double lower_sigmas = 0;                   // lately
  bool has_hopped = false, is_over = false;  // over: it rolls

  void predict(double to_s, const BallModel& model);
  void correct(const ShotPoint& seen, const BallModel& model);
  /// Its size tells again and again that it is lower.
  bool is_doubtful() const;
  /// What turned its way along the floor; it falls as before.
  void turn(double place_sigma_mm);
  /// The same way.
  BallShot shot(const BallModel& model) const;

 private:
  void hop(const BallModel& model);
};

/// Whether a ball of which nothing is known was in the air in these sightings, rather than on the floor.
/// Nothing when it was not, or when they do not tell.
std::optional<BallFlight> find_flight(std::span<const ShotPoint> points, const BallModel& model);

}  // namespace sslv
