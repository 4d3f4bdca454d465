// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/simulator/simulator_hall.h"
#include "capture/simulator/simulator_lamps.h"
#include "capture/simulator/simulator_paint.h"
#include "geometry/field.h"

#include <Eigen/Core>

namespace sslv {

/// What a hall's carpet looks like, without lines.
class SimulatedCarpet {
 public:
  /// `hall` must be resolved.
  SimulatedCarpet(const HallOptions& hall, const FieldSize& field, const SimulatedLamps& lamps);

  /// The brightness of pile and dust, as a factor, on the carpet and beside it.
  static float tone_at(const Eigen::Vector2d& field_mm);

  /// Seen from `eye_mm`, where sheen depends on.
  Paint at(const Eigen::Vector2d& field_mm, const Eigen::Vector3d& eye_mm) const;

 private:
  /// Light and dark patches.
  struct Blotches {
    float contrast;
    double size_mm;
  };
  /// The widths that a carpet is laid in, side by side.
  struct Strips {
    double width_mm;  // 0: it is in one piece
    float step;       // between the brightness of neighbours
    float seams;      // the contrast of the lines where they meet
    bool along_x;
  };

  float wear_at(const Eigen::Vector2d& field_mm, const Eigen::Vector2d& place_mm) const;
  void lay_strips(double across_mm, double along_mm, float& bright) const;

  Paint base_;
  bool is_even_;  // but for its tone
  Blotches blotches_;
  Strips strips_;
  float tint_, weave_, wear_, shine_;
  Eigen::Vector2d offset_mm_;  // into the noise
  Eigen::Vector2d goal_mm_;    // the place before a goal where most is driven; the other one mirrors it
  Eigen::Vector3d lamp_mm_;    // that is mirrored
};

}  // namespace sslv
