// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "colors/small_picture.h"

#include <cstddef>
#include <vector>

namespace sslv {

/// A place that differs from what lies around it, as large as was asked for.
struct Spot {
  Eigen::Vector2d pixel;
  Color3 color, around;  // of its middle, and of a ring about it
  double contrast;       // length of their difference, as a share of what is around: the same in any light
};

enum class SpotsOf {
  kBrighter,  // than what lies around: dots on black
  kAnyColor,  // balls on a carpet
};

/// The image's spots of some radius, those of most contrast first, `most` of them at most. `noise_grey` is
/// that of one pixel.
std::vector<Spot> find_spots(const SmallPicture& picture, double radius_px, double noise_grey, SpotsOf kind,
                             std::size_t most);

/// The cell size for spots of a radius: small enough for them, no smaller, so that large images take no
/// longer than small ones.
int cell_px_for(PixelFormat format, double radius_px);

}  // namespace sslv
