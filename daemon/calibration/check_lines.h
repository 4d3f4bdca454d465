// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/painted_curves.h"
#include "geometry/camera_model.h"
#include "geometry/field.h"
#include "image/image.h"

#include <cstddef>
#include <span>
#include <vector>

namespace sslv {

/// Position of one painted line or arc in an image.
struct LineSeen {
  std::size_t curve = 0;  // index into the given curves
  int points = 0;         // sample points in view
  int found = 0;          // sample points with a stripe
  double offset_mm = 0;   // median offset of the stripes from the expected line, across it
};

/// Searches for the painted lines up to `window_mm` on both sides of their expected positions, at no more
/// than about 200 sample points. This takes a fraction of a millisecond for images of any size. A covered
/// sample point counts as a sample point without a stripe. Lines with fewer than five sample points in the
/// image are left out.
std::vector<LineSeen> check_lines(const ImageView& image, const CameraModel& camera,
                                  std::span<const PaintedCurve> curves, double window_mm);

/// Summary of what check_lines() found.
struct LinesVerdict {
  int lines = 0;             // lines checked
  double worst_mm = 0;       // largest absolute offset of a line that was found
  std::size_t worst = 0;     // curve of that line
  double missing_share = 0;  // share of the sample points that lie on lines not found
  int good = 0;              // number of stripes on lines near their expected position
};
LinesVerdict judge_lines(std::span<const LineSeen> lines);

/// The field size of the league that fits the lines in this image clearly better than `size`, whose verdict
/// is `judged`; null if there is none. `judged` alone may look fine, because the lines that would contradict
/// a wrong size may lie outside the image.
const FieldPreset* find_better_size(const ImageView& image, const CameraModel& camera, const FieldSize& size,
                                    const LinesVerdict& judged, double window_mm);

}  // namespace sslv
