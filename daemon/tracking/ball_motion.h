// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace sslv {

inline constexpr double kGravity_mm_s2 = 9810;

/// How a ball goes on: slides, rolls, bounces; and where it is played.
struct BallModel {
  double slides_mm_s2 = 3400, rolls_mm_s2 = 330;
  double rolls_from_share = 5.0 / 7;  // of the speed at which it began to slide
  double first_hop_xy = 0.75, later_hops_xy = 0.95, hops_z = 0.6;
  double radius_mm = 21.5;
  double half_length_mm = 6000, half_width_mm = 4500;  // of the field
};

struct BallState {
  Eigen::Vector3d place_mm, velocity_mm_s;
};

/// A ball that was hit at a moment, and goes its way since: along the floor, or through the air and in hops.
struct BallShot {
  double t_s = 0;
  Eigen::Vector2d place_mm{0, 0};
  Eigen::Vector3d velocity_mm_s{0, 0, 0};
  double height_mm = 0;     // over the floor, of one that was turned in the air
  bool has_hopped = false;  // before
  /// A ball that leaves the floor slower rolls on.
  static constexpr double kLastHop_mm_s = 350;

  bool is_chip() const { return velocity_mm_s.z() > 0 || height_mm > 0; }
  BallState at(double time_s, const BallModel& model) const;
  double lands_after_s() const;
  /// When it lies still.
  double stops_s(const BallModel& model) const;
  /// Where a chip comes down first; the place itself for one along the floor.
  Eigen::Vector2d landing_mm() const;
};

/// How far a ball that had this speed when it began to slide has come after so long, and how fast it is then.
struct FlatWay {
  double way_mm, speed_mm_s;
};
FlatWay flat_way(double speed_mm_s, double passed_s, const BallModel& model);

}  // namespace sslv
