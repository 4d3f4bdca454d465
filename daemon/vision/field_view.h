// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geometry/scene.h"
#include "vision/mask.h"

#include <vector>

namespace sslv {

/// Where a calibrated camera sees its field: the ground up to the boundary, or as far as set, and robots
/// that stand there. The hall around it costs time and looks like balls.
struct FieldView {
  static constexpr int kBandPx = 16;  // rows that are treated alike
  /// Pixels of each band of rows: ascending, disjoint, none empty, ends multiples of kBandPx. What lies below
  /// the last band, or right of `width_px`, is not in the image that the calibration is for: it is shown.
  std::vector<std::vector<Mask::Interval>> bands;
  int width_px = 0;
};

/// `scene` must have a camera. Asks for each corner of a grid of kBandPx which place of the field it shows:
/// outlines of the field cannot be projected where the lens folds them over or the horizon cuts them.
FieldView field_view(const Scene& scene, double beyond_boundary_mm);

/// A part of an image.
struct PixelRectangle {
  int left_px, top_px, width_px, height_px;
};
/// What the view leaves out, in as many rectangles as it takes.
std::vector<PixelRectangle> hidden_by(const FieldView& view);

}  // namespace sslv
