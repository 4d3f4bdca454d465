// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>

#include <Eigen/Core>

namespace sslv {

/// Wraps to -pi .. pi.
inline double around(double angle_rad) {
  return std::remainder(angle_rad, 2 * std::numbers::pi);
}

inline double direction_of(const Eigen::Vector2d& v) {
  return std::atan2(v.y(), v.x());
}

inline Eigen::Vector2d unit_of(const Eigen::Vector2d& v) {
  const double length = v.norm();
  return length > 1e-9 ? Eigen::Vector2d(v / length) : Eigen::Vector2d(0, 0);
}

inline Eigen::Vector2d turned_by(const Eigen::Vector2d& v, double angle_rad) {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  return {c * v.x() - s * v.y(), s * v.x() + c * v.y()};
}

inline Eigen::Vector2d left_of(const Eigen::Vector2d& v) {
  return {-v.y(), v.x()};
}

}  // namespace sslv
