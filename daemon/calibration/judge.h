// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/line_picture.h"
#include "calibration/painted_curves.h"
#include "calibration/refine.h"
#include "geometry/field.h"

#include <span>

namespace sslv {

/// How far a camera explains an image of the field.
struct Verdict {
  double rms_px = 0;
  double found_share = 0;        // of the lines in view
  double unexplained_share = 0;  // of the bright stripes on the field: on none of its lines

  /// Stripes that are no lines count against lines found: a camera that is taken for another always leaves
  /// some, and missing lines leave none.
  double credit() const;
  bool lines_are_near() const;
  bool lines_are_found() const;
  bool is_acceptable() const { return lines_are_near() && lines_are_found(); }
};

inline constexpr double kMaxRmsPx = 0.6;  // of lines that are near

Verdict judge(const RefinedCamera& refined, const LinePicture& picture, std::span<const PaintedCurve> curves,
              const FieldSize& field);

}  // namespace sslv
