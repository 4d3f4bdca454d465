// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/painted_curves.h"
#include "calibration/refine.h"
#include "geometry/field.h"

#include <optional>
#include <span>
#include <vector>

namespace sslv {

/// The part of the lines (middle or outer edge) to which the field's sizes were measured, and the lens model
/// of each camera.
struct CalibrationModel {
  struct Lens {
    bool two_radial = false;
    LensCamera camera;  // initial value for fitting this model
  };
  LinesMeasured measured = LinesMeasured::kToMiddle;
  std::vector<Lens> lenses;
};

/// Chooses the model for cameras over one field. The cameras must have been fitted with one radial term to
/// the field's lines, for sizes measured to the middle of the lines unless `given` states otherwise. Another
/// model is chosen only if it explains the lines clearly better. `given`: the part of the lines to which the
/// sizes were measured, if known.
CalibrationModel choose_model(std::span<const RefinedCamera> cameras, const FieldCurves& curves,
                              std::optional<LinesMeasured> given);

}  // namespace sslv
