// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"
#include "vision/lut.h"
#include "vision/mask.h"
#include "vision/regions.h"

#include <tuple>

namespace sslv {

/// Sets the cells that the mask hides to clear.
void clear_masked(const Mask& mask, LabelImage& labels);

/// Labels every pixel by the colour lookup table: the plain reference (Bruce, Balch, Veloso: Fast and
/// Inexpensive Color Image Segmentation for Interactive Robots, IROS 2000). Bayer images are read as 2x2
/// quads of one red, two green (averaged, rounded up) and one blue sample, with one label per quad; mono
/// pixels count as grey. Cells that the mask hides are clear.
class Threshold {
 public:
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, const Lut& lut, const Mask& mask, const Image& image,
               LabelImage& labels) noexcept;
};

}  // namespace sslv
