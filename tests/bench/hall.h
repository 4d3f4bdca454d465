// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"
#include "lab/bench.h"
#include "vision/lut.h"

#include <array>
#include <cstdint>
#include <memory>

namespace sslv::bench {

/// A realistic hall: what the simulator's plain scene lacks.
struct HallKind {
  const char* name;
  double carpet_texture;        // carpet blotches: standard deviation relative to its brightness
  double floor_texture;         // the same for the floor
  double lamps;                 // amplitude of the lamps' unevenness, relative to the brightness
  double vignette;              // relative darkening of the corners
  double noise_sigma;           // of red, green and blue each, before mosaicing or conversion
  std::array<double, 8> light;  // brightness of successive frames
};
inline constexpr HallKind kUsualHall{
    "usual", 0.115, 0.05, 0.15, 0.2, 4, {1, 0.88, 1.12, 0.95, 1.05, 0.9, 1.1, 1}};
inline constexpr HallKind kHardHall{"hard", 0.16, 0.1, 0.2, 0.3, 5, {1, 0.75, 1.33, 0.85, 1.2, 0.8, 1.1, 1}};

/// The demo's scene in such a hall, with a carpet of (34, 98, 48) and a dark grey floor.
Recording draw_hall(const HallKind& hall, PixelFormat format, int width, int height, int frames);

/// A table with margins: carpet and floor are clear up to 1.5 times the hall's brightness; brighter carpet is
/// "green"; all other labels depend on hue only.
std::shared_ptr<const Lut> lut_with_margins(const HallKind& hall);

/// The table that learn_colors() learns from one of these images; null when it reports a problem.
std::shared_ptr<const Lut> learnt_lut(const Recording& recording, int width, int height);

}  // namespace sslv::bench
