// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/line_picture.h"
#include "calibration/painted_curves.h"
#include "calibration/refine.h"
#include "geometry/field.h"

#include <span>

namespace sslv {

/// Measures of how well a camera explains an image of the field.
struct Verdict {
  double rms_px = 0;
  double found_share = 0;        // share of the line patches in view
  double unexplained_share = 0;  // share of the stripe pixels on the field that no line explains
  double px_per_mm = 1;

  /// found_share minus a multiple of unexplained_share. A wrong camera always leaves stripes unexplained;
  /// lines missing on the floor do not.
  double credit() const;
  double rms_mm() const { return rms_px / px_per_mm; }
  /// Straight lines lie within kMaxRmsPx. Paint and tape may be uneven by kUnevenMm, which takes more pixels
  /// in a large image.
  double max_rms_px() const;
  bool lines_are_near() const { return rms_px < max_rms_px(); }
  bool lines_are_found() const;
  bool is_acceptable() const { return lines_are_near() && lines_are_found(); }
};

inline constexpr double kMaxRmsPx = 0.6;

Verdict judge(const RefinedCamera& refined, const LinePicture& picture, std::span<const PaintedCurve> curves,
              const FieldSize& field);

}  // namespace sslv
