// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geometry/camera_model.h"
#include "light_color.h"
#include "solids.h"

#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace sslv::halls {

struct Lamp {
  Eigen::Vector3d at_mm;
  double strength = 1;
  Color tint = Color::Ones();
};

/// What the lamps of a hall do to its light.
struct Lighting {
  std::vector<Lamp> lamps;
  /// The light on the seen part of the field lies within 1 - uneven .. 1 + uneven of its mean, and reaches
  /// one of both.
  double uneven = 0.15;
  double vignette = 0.15;     // the corners of the picture are darker by this share
  double lamp_jitter = 0;     // standard deviation of each lamp from frame to frame
  double banding = 0;         // brightness of the bands of a mains flicker, as a share
  double banding_rows = 200;  // one band
};

/// Light on the floor as one picture shows it: a grid of nodes every few pixels, linear in between.
class LightMap {
 public:
  /// `area_mm`: over which the lamps are uneven.
  LightMap(const Lighting& lighting, const CameraModel& camera, const Eigen::AlignedBox2d& area_mm);

  /// Lets each lamp shine so much.
  void shine(std::span<const double> factors);
  Color at(double pixel_x, double pixel_y) const;
  /// Multiplies a row of colours with the light that falls there.
  void light_row(int y, std::span<Color> row) const;

  LightFrom from(const Eigen::Vector2d& place_mm) const;

 private:
  static constexpr int kStep = 16;
  const Lighting& lighting_;
  int columns_, rows_, width_, height_;
  std::vector<Color> of_lamp_;  // [lamp][row][column]
  std::vector<Color> nodes_;    // [row][column]
};

}  // namespace sslv::halls
