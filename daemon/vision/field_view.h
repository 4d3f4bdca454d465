// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geometry/scene.h"
#include "vision/mask.h"

#include <vector>

namespace sslv {

/// The part of an image that shows a calibrated camera's field: the ground up to the boundary, or up to a
/// configured distance beyond it, and robots that stand there. The rest of the hall would cost time and
/// contains objects that look like balls.
struct FieldView {
  static constexpr int kBandPx = 16;  // number of rows in a band
  /// Visible pixels of each band of rows: ascending, disjoint, none empty, ends multiples of kBandPx. Pixels
  /// below the last band or right of `width_px` are outside the image size of the calibration and count as
  /// visible.
  std::vector<std::vector<Mask::Interval>> bands;
  int width_px = 0;
};

/// `scene` must have a camera. Projects each corner of a grid of kBandPx to the field, instead of the field's
/// outline to the image, because the lens model may fold the outline and the horizon may cut it.
FieldView field_view(const Scene& scene, double beyond_boundary_mm);

/// A part of an image.
struct PixelRectangle {
  int left_px, top_px, width_px, height_px;
};
/// The hidden part of the image, as rectangles.
std::vector<PixelRectangle> hidden_by(const FieldView& view);

}  // namespace sslv
