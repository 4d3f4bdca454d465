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

/// How one painted line or arc lies in an image.
struct LineSeen {
  std::size_t curve = 0;  // of those that were looked for
  int points = 0;         // places of it that the camera should show
  int found = 0;          // of them, those where a stripe stands out
  double offset_mm = 0;   // across the line, of the stripes from where they should be: their median
};

/// Looks for the painted lines near where the calibration puts them, at no more than some hundred places: a
/// fraction of a millisecond, however large the image is. A place where something lies on the line counts as
/// one without a stripe. Lines with fewer than five places in the image are left out. `window_mm`: how far to
/// both sides.
std::vector<LineSeen> check_lines(const ImageView& image, const CameraModel& camera,
                                  std::span<const PaintedCurve> curves, double window_mm);

/// What check_lines() found, as one figure for people.
struct LinesVerdict {
  int lines = 0;             // that could be judged
  double worst_mm = 0;       // the largest offset of a line that was found
  std::size_t worst = 0;     // which it is
  double missing_share = 0;  // of the places: those on lines that were not found
  int good = 0;              // places where a line was found, and near where it should be
};
LinesVerdict judge_lines(std::span<const LineSeen> lines);

/// Which of the league's field sizes suits the lines in this image clearly better than those that `judged` is
/// of; null: none does. The camera may show no line that the wrong sizes have, so these alone look fine.
const FieldPreset* find_better_size(const ImageView& image, const CameraModel& camera, const FieldSize& size,
                                    const LinesVerdict& judged, double window_mm);

}  // namespace sslv
