// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ctl/bench.h"
#include "image/image.h"
#include "vision/lut.h"

#include <array>
#include <cstdint>
#include <memory>

namespace sslv::bench {

/// A hall as they are: what the simulator's plain scene lacks.
struct HallKind {
  const char* name;
  double carpet_texture;        // blotches of the carpet: standard deviation, as a share of its brightness
  double floor_texture;         // the same of the floor
  double lamps;                 // how far the lamps' unevenness takes the brightness up and down, as a share
  double vignette;              // share by which the corners are darker
  double noise_sigma;           // of each of red, green and blue, before they are mixed
  std::array<double, 8> light;  // of the frames, in turn
};
inline constexpr HallKind kUsualHall{
    "usual", 0.115, 0.05, 0.15, 0.2, 4, {1, 0.88, 1.12, 0.95, 1.05, 0.9, 1.1, 1}};
inline constexpr HallKind kHardHall{"hard", 0.16, 0.1, 0.2, 0.3, 5, {1, 0.75, 1.33, 0.85, 1.2, 0.8, 1.1, 1}};

/// The demo's scene in such a hall: a carpet of (34, 98, 48), a dark grey floor.
Recording draw_hall(const HallKind& hall, PixelFormat format, int width, int height, int frames);

/// A table with margins: all brightnesses of carpet and floor up to 1.5 times the hall's own are clear, and
/// brighter ones of the carpet's colour are "green"; other labels by their hues.
std::shared_ptr<const Lut> lut_with_margins(const HallKind& hall);

/// What learn_colors() learns from one of those pictures; none when it finds a problem.
std::shared_ptr<const Lut> learnt_lut(const Recording& recording, int width, int height);

}  // namespace sslv::bench
