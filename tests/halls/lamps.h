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

/// The light in a hall.
struct Lighting {
  std::vector<Lamp> lamps;
  /// The light on the visible part of the field is within 1 - uneven .. 1 + uneven of its mean, and reaches
  /// one of these bounds.
  double uneven = 0.15;
  double vignette = 0.15;     // relative darkening of the image corners
  double lamp_jitter = 0;     // standard deviation of each lamp between frames
  double banding = 0;         // relative amplitude of mains flicker bands
  double banding_rows = 200;  // period of the bands
};

/// Light on the floor per image pixel: a grid of nodes every few pixels, linearly interpolated.
class LightMap {
 public:
  /// `area_mm`: the area over which the unevenness is defined.
  LightMap(const Lighting& lighting, const CameraModel& camera, const Eigen::AlignedBox2d& area_mm);

  /// Sets the brightness of each lamp.
  void shine(std::span<const double> factors);
  Color at(double pixel_x, double pixel_y) const;
  /// Multiplies a row of colours by the light there.
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
