// SPDX-License-Identifier: Apache-2.0
#include "tracking/ball_motion.h"

#include <algorithm>
#include <cmath>

namespace sslv {

using Eigen::Vector2d, Eigen::Vector3d;

namespace {

Vector2d way_of(const Vector2d& v) {
  const double length = v.norm();
  return length > 1e-9 ? Vector2d(v / length) : Vector2d(0, 0);
}

}  // namespace

FlatWay flat_way(double speed_mm_s, double passed_s, const BallModel& model) {
  if (passed_s <= 0) return {speed_mm_s * passed_s, speed_mm_s};
  const double slides_s =
      std::min(passed_s, speed_mm_s * (1 - model.rolls_from_share) / std::max(1.0, model.slides_mm_s2));
  const double rolls_from = speed_mm_s - model.slides_mm_s2 * slides_s;
  const double rolls_s = std::min(passed_s - slides_s, rolls_from / std::max(1.0, model.rolls_mm_s2));
  return {speed_mm_s * slides_s - 0.5 * model.slides_mm_s2 * slides_s * slides_s + rolls_from * rolls_s -
              0.5 * model.rolls_mm_s2 * rolls_s * rolls_s,
          rolls_from - model.rolls_mm_s2 * rolls_s};
}

BallState BallShot::at(double time_s, const BallModel& model) const {
  double left_s = time_s - t_s;
  if (!is_chip() || (left_s <= 0 && height_mm <= 0)) {
    const Vector2d flat = velocity_mm_s.head<2>(), way = way_of(flat);
    const FlatWay gone = flat_way(flat.norm(), left_s, model);
    const Vector2d place = place_mm + way * gone.way_mm, velocity = way * gone.speed_mm_s;
    return {{place.x(), place.y(), model.radius_mm}, {velocity.x(), velocity.y(), 0}};
  }
  Vector2d place = place_mm, velocity = velocity_mm_s.head<2>();
  double up = velocity_mm_s.z(), from_mm = height_mm;
  for (bool is_first = true; up >= kLastHop_mm_s || is_first; is_first = false) {
    const double down = std::sqrt(up * up + 2 * kGravity_mm_s2 * from_mm),
                 hop_s = (up + down) / kGravity_mm_s2;
    if (left_s < hop_s) {
      const Vector2d here = place + velocity * left_s;
      const double height = from_mm + up * left_s - 0.5 * kGravity_mm_s2 * left_s * left_s;
      return {{here.x(), here.y(), model.radius_mm + height},
              {velocity.x(), velocity.y(), up - kGravity_mm_s2 * left_s}};
    }
    left_s -= hop_s;
    place += velocity * hop_s;
    velocity *= is_first && !has_hopped ? model.first_hop_xy : model.later_hops_xy;
    up = down * model.hops_z;
    from_mm = 0;
  }
  const double speed = velocity.norm();
  const double rolls_s = std::min(left_s, speed / std::max(1.0, model.rolls_mm_s2));
  const Vector2d way = way_of(velocity);
  place += way * (speed * rolls_s - 0.5 * model.rolls_mm_s2 * rolls_s * rolls_s);
  velocity = way * (speed - model.rolls_mm_s2 * rolls_s);
  return {{place.x(), place.y(), model.radius_mm}, {velocity.x(), velocity.y(), 0}};
}

double BallShot::stops_s(const BallModel& model) const {
  // Upper limit: every ball comes to rest earlier.
  constexpr double kLongest_s = 60, kStill_mm_s = 1;
  double moves_s = 0, still_s = kLongest_s;
  for (int i = 0; i < 16; ++i) {
    const double middle_s = (moves_s + still_s) / 2;
    (at(t_s + middle_s, model).velocity_mm_s.norm() > kStill_mm_s ? moves_s : still_s) = middle_s;
  }
  return t_s + still_s;
}

double BallShot::lands_after_s() const {
  const double up = velocity_mm_s.z(), down = std::sqrt(up * up + 2 * kGravity_mm_s2 * height_mm);
  return std::max(0.0, up + down) / kGravity_mm_s2;
}

Vector2d BallShot::landing_mm() const {
  return place_mm + velocity_mm_s.head<2>() * lands_after_s();
}

}  // namespace sslv
