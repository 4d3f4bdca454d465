// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/painted_curves.h"
#include "calibration/refine.h"
#include "geometry/field.h"

#include <optional>
#include <span>
#include <vector>

namespace sslv {

/// How to describe a field, and the lenses of the cameras over it.
struct CalibrationModel {
  struct Lens {
    bool two_radial = false;
    LensCamera camera;  // a start for fitting that
  };
  LinesMeasured measured = LinesMeasured::kToMiddle;
  std::vector<Lens> lenses;
};

/// What suits best the cameras over one field that were fitted to its lines with one radial term, measured to
/// their middle unless `given` says otherwise: another model is taken when it explains the lines clearly
/// better. `given`: what the sizes were measured to, if known.
CalibrationModel choose_model(std::span<const RefinedCamera> cameras, const FieldCurves& curves,
                              std::optional<LinesMeasured> given);

}  // namespace sslv
