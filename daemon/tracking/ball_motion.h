// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace sslv {

inline constexpr double kGravity_mm_s2 = 9810;

/// Ball dynamics (sliding, rolling, bouncing) and the size of the field.
struct BallModel {
  double slides_mm_s2 = 3400, rolls_mm_s2 = 330;
  double rolls_from_share = 5.0 / 7;  // speed when rolling begins / speed when sliding begins
  double first_hop_xy = 0.75, later_hops_xy = 0.95, hops_z = 0.6;
  double radius_mm = 21.5;
  double half_length_mm = 6000, half_width_mm = 4500;  // half of the field
};

/// Position of a ball's centre, in field millimetres above the floor, and its velocity.
struct BallState {
  Eigen::Vector3d place_mm, velocity_mm_s;
};

/// Trajectory of a ball that was hit at `t_s`: along the floor, or through the air with bounces.
struct BallShot {
  double t_s = 0;
  Eigen::Vector2d place_mm{0, 0};
  Eigen::Vector3d velocity_mm_s{0, 0, 0};
  double height_mm = 0;     // initial height above the floor, if the shot starts in the air
  bool has_hopped = false;  // has bounced before t_s
  /// A ball that rebounds from the floor with a lower vertical speed rolls from then on.
  static constexpr double kLastHop_mm_s = 350;

  /// True if the shot goes through the air.
  bool is_chip() const { return velocity_mm_s.z() > 0 || height_mm > 0; }
  /// State at this time, in seconds of `t_s`'s clock.
  BallState at(double time_s, const BallModel& model) const;
  /// Seconds from `t_s` to the first landing; 0 for a shot along the floor.
  double lands_after_s() const;
  /// Time at which the ball comes to rest.
  double stops_s(const BallModel& model) const;
  /// First landing point of a chip; `place_mm` for a shot along the floor.
  Eigen::Vector2d landing_mm() const;
};

/// Distance and speed of a ball `passed_s` after it began to slide at `speed_mm_s`.
struct FlatWay {
  double way_mm, speed_mm_s;
};
FlatWay flat_way(double speed_mm_s, double passed_s, const BallModel& model);

}  // namespace sslv
