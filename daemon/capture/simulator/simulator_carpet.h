// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/simulator/simulator_hall.h"
#include "capture/simulator/simulator_lamps.h"
#include "capture/simulator/simulator_paint.h"
#include "geometry/field.h"

#include <Eigen/Core>

namespace sslv {

/// The appearance of a hall's carpet, without lines.
class SimulatedCarpet {
 public:
  /// `hall` must be resolved.
  SimulatedCarpet(const HallOptions& hall, const FieldSize& field, const SimulatedLamps& lamps);

  /// Brightness factor of pile and dust, on the carpet and beside it.
  static float tone_at(const Eigen::Vector2d& field_mm);

  /// The colour seen from `eye_mm`, on which the sheen depends.
  Paint at(const Eigen::Vector2d& field_mm, const Eigen::Vector3d& eye_mm) const;

 private:
  /// Light and dark patches.
  struct Blotches {
    float contrast;
    double size_mm;
  };
  /// The strips in which the carpet is laid, side by side.
  struct Strips {
    double width_mm;  // 0: a single piece, without strips
    float step;       // maximum deviation of a strip's brightness
    float seams;      // contrast of the lines between strips
    bool along_x;
  };

  float wear_at(const Eigen::Vector2d& field_mm, const Eigen::Vector2d& place_mm) const;
  void lay_strips(double across_mm, double along_mm, float& bright) const;

  Paint base_;
  bool is_even_;  // the carpet has one colour, except for tone_at()
  Blotches blotches_;
  Strips strips_;
  float tint_, weave_, wear_, shine_;
  Eigen::Vector2d offset_mm_;  // offset into the noise
  Eigen::Vector2d goal_mm_;    // the most worn place in front of a goal; mirrored for the other goal
  Eigen::Vector3d lamp_mm_;    // the lamp that the sheen reflects
};

}  // namespace sslv
