// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geometry/field.h"
#include "light_color.h"

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace sslv::halls {

/// The carpet and its variation. Strengths are relative to its brightness; 0: absent.
struct Carpet {
  Color color;
  Eigen::AlignedBox2d extent_mm;
  std::uint32_t seed = 1;
  double blotches = 0, blotch_mm = 300;     // low-frequency stains, three octaves
  double hue = 0;                           // stains in blue, twice as strong in red
  double pile = 0, pile_mm = 4, brush = 0;  // fibres; patches brushed in another direction
  double weave = 0, weave_mm = 11;
  double tiles = 0, tile_mm = 500;  // alternating direction
  double seams = 0, seam_mm = 4;    // dark lines between tiles
  double worn = 0;                  // paler paths between the goals
  double field_length_mm = 9000, field_width_mm = 6000;
};

/// Reflection of a lamp in the carpet; adds white light.
struct Shine {
  Eigen::Vector2d at_mm, radii_mm;
  double strength = 0;
};

/// The floor around the carpet.
struct Ground {
  Color color;
  bool planks = false;
  std::uint32_t seed = 1;
};

/// Something flat: a line, a piece of tape, a part of a cable. Its ends are straight.
struct Stripe {
  Eigen::Vector2d a_mm, b_mm;
  double half_width_mm = 5;
  Color color;
  bool in_the_way = false;  // an obstacle: nothing is placed on it

  /// Negative inside.
  double distance_mm(const Eigen::Vector2d& point_mm) const;
};

struct Ring {
  Eigen::Vector2d center_mm;
  double radius_mm, half_width_mm;
  Color color;
  double distance_mm(const Eigen::Vector2d& point_mm) const {
    return std::abs((point_mm - center_mm).norm() - radius_mm) - half_width_mm;
  }
};

struct Floor {
  Carpet carpet;
  Ground ground;
  std::vector<Shine> shines;
  std::vector<Stripe> stripes;  // later ones are on top
  std::vector<Ring> rings;
  double line_wear = 0;  // fraction of the lines' paint that is worn off
};

/// Adds the field's lines in one colour.
void paint_lines(const FieldSize& field, const Color& color, Floor& floor);

/// Colours a pixel of the floor, given its corner and its two sides in mm.
class FloorPatch {
 public:
  explicit FloorPatch(const Floor& floor) : floor_(floor) {}
  /// Limits the next pixels to this circle.
  void look_around(const Eigen::Vector2d& middle_mm, double radius_mm);
  /// The pixel's mean colour. `in_the_way` returns whether an obstacle is there.
  Color color(const Eigen::Vector2d& middle, const Eigen::Vector2d& right, const Eigen::Vector2d& down,
              bool& in_the_way);

 private:
  Color carpet_tone(const Eigen::Vector2d& p) const;
  Color carpet(const Eigen::Vector2d& p) const;
  Color ground(const Eigen::Vector2d& p) const;
  Color at(const Eigen::Vector2d& p, const Color& tone) const;

  const Floor& floor_;
  std::vector<const Stripe*> around_;   // stripes that may touch the next pixels
  std::vector<const Stripe*> stripes_;  // stripes near the current pixel
  std::vector<const Ring*> rings_;
};

}  // namespace sslv::halls
