// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/simulator/simulator_hall.h"
#include "capture/simulator/simulator_paint.h"
#include "geometry/field.h"

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace sslv {

/// A hall's lamps: the light at each position, and its changes.
class SimulatedLamps {
 public:
  /// `hall` must be resolved.
  SimulatedLamps(const HallOptions& hall, const FieldSize& field);

  /// Whether at() is 1 everywhere.
  bool even() const { return uneven_ == 0 && cast_ == 0; }
  /// Factors on red, green and blue at a place on the field.
  Paint at(const Eigen::Vector2d& field_mm) const;

  std::span<const Eigen::Vector3d> places_mm() const { return places_mm_; }

  bool flickers() const { return flicker_low_ != 1 || flicker_high_ != 1; }
  /// Light factor of this image number, in a scene with this seed.
  double flicker(int scene_seed, std::int64_t picture) const;

 private:
  double sum_at(const Eigen::Vector2d& field_mm) const;

  float uneven_, cast_;
  double flicker_low_, flicker_high_;
  std::vector<Eigen::Vector3d> places_mm_;
  std::vector<double> strengths_;
  double mean_ = 1, scale_ = 0;  // mean of sum_at() on the field; factor on deviations from that mean
  // Direction in which red increases; the dot product with a position in mm is -1 .. 1 on the field.
  Eigen::Vector2d warm_side_;
};

}  // namespace sslv
