// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "colors/small_picture.h"

#include <cstddef>
#include <vector>

namespace sslv {

/// A spot of about the requested size that differs from its surroundings.
struct Spot {
  Eigen::Vector2d pixel;
  Color3 color, around;  // colour of the spot's middle; colour of a ring around it
  double contrast;       // length of color - around, relative to `around`; independent of the light
};

enum class SpotsOf {
  kBrighter,  // brighter than the surroundings: dots on black
  kAnyColor,  // balls on a carpet
};

/// Spots of the given radius, highest contrast first, at most `most`. `noise_grey`: noise of one pixel in
/// grey levels.
std::vector<Spot> find_spots(const SmallPicture& picture, double radius_px, double noise_grey, SpotsOf kind,
                             std::size_t most);

/// Cell size in px for spots of a radius: as coarse as the radius allows, so that large images take no longer
/// than small images.
int cell_px_for(PixelFormat format, double radius_px);

}  // namespace sslv
