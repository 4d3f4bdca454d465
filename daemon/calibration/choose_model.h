// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/camera_prior.h"
#include "calibration/painted_curves.h"
#include "calibration/refine.h"
#include "geometry/field.h"

#include <optional>
#include <span>
#include <vector>

namespace sslv {

/// The lines of a field as they are painted, for both ways to measure its sizes.
struct FieldCurves {
  explicit FieldCurves(const FieldSize& field);

  std::span<const PaintedCurve> measured(LinesMeasured to) const {
    return to == LinesMeasured::kToOuterEdge ? to_outer_edge : to_middle;
  }

  std::vector<PaintedCurve> to_outer_edge, to_middle;
};

/// How to describe a field and a lens.
struct CalibrationModel {
  LinesMeasured measured = LinesMeasured::kToOuterEdge;
  bool two_radial = false;
  LensCamera camera;  // a start for fitting that
};

/// What suits best a camera that was fitted to lines with one radial term: a model with more than that is
/// taken when it explains the lines clearly better. `given`: what the sizes were measured to, if known.
CalibrationModel choose_model(const RefinedCamera& refined, const FieldCurves& curves,
                              std::optional<LinesMeasured> given, const CameraPrior& prior);

}  // namespace sslv
