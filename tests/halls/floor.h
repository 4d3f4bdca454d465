// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geometry/field.h"
#include "light_color.h"

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace sslv::halls {

/// The carpet and how it differs from place to place. Strengths are shares of its brightness; 0: not there.
struct Carpet {
  Color color;
  Eigen::AlignedBox2d extent_mm;
  std::uint32_t seed = 1;
  double blotches = 0, blotch_mm = 300;     // low-frequency stains, over three octaves
  double hue = 0;                           // stains of blue, twice as strong of red
  double pile = 0, pile_mm = 4, brush = 0;  // fibres; patches brushed another way
  double weave = 0, weave_mm = 11;
  double tiles = 0, tile_mm = 500;  // each laid another way round
  double seams = 0, seam_mm = 4;    // dark, between tiles
  double worn = 0;                  // paler paths between the goals
  double field_length_mm = 9000, field_width_mm = 6000;
};

/// Where a lamp is mirrored in the carpet; adds white light.
struct Shine {
  Eigen::Vector2d at_mm, radii_mm;
  double strength = 0;
};

/// What lies around the carpet.
struct Ground {
  Color color;
  bool planks = false;
  std::uint32_t seed = 1;
};

/// Painted or lying flat: a line, a piece of tape, a part of a cable. Its ends are straight.
struct Stripe {
  Eigen::Vector2d a_mm, b_mm;
  double half_width_mm = 5;
  Color color;
  bool in_the_way = false;  // nothing is put onto it

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
  std::vector<Stripe> stripes;  // later ones lie on top
  std::vector<Ring> rings;
  double line_wear = 0;  // share of the lines' paint that has gone
};

/// The field's lines in one colour.
void paint_lines(const FieldSize& field, const Color& color, Floor& floor);

/// The part of a floor around one pixel, whose middle and two sides are given in millimetres.
class FloorPatch {
 public:
  explicit FloorPatch(const Floor& floor) : floor_(floor) {}
  /// The next pixels lie within this circle.
  void look_around(const Eigen::Vector2d& middle_mm, double radius_mm);
  /// The mean colour of the pixel. `in_the_way` tells whether something lies there.
  Color color(const Eigen::Vector2d& middle, const Eigen::Vector2d& right, const Eigen::Vector2d& down,
              bool& in_the_way);

 private:
  Color carpet_tone(const Eigen::Vector2d& p) const;
  Color carpet(const Eigen::Vector2d& p) const;
  Color ground(const Eigen::Vector2d& p) const;
  Color at(const Eigen::Vector2d& p, const Color& tone) const;

  const Floor& floor_;
  std::vector<const Stripe*> around_;   // all that may touch the next pixels
  std::vector<const Stripe*> stripes_;  // near the pixel
  std::vector<const Ring*> rings_;
};

}  // namespace sslv::halls
