// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/calibration_report.h"
#include "calibration/calibration_task.h"
#include "calibration/camera_prior.h"
#include "calibration/judge.h"
#include "calibration/painted_curves.h"
#include "calibration/refine.h"

#include <optional>
#include <span>
#include <vector>

namespace sslv {

/// What was found, and all that it is told by.
struct Finding {
  const CalibrationTask& task;
  const Clicks& clicks;
  const CameraPrior& prior;
  std::span<const PaintedCurve> curves;
  LinesMeasured measured;
  const RefinedCamera& refined;
  Verdict verdict;
  bool either_way_round;  // turned by half a turn it suits the picture as well
  bool only_one;          // no other part of the field suits the picture
};

/// Figures for people and programs, and in plain words what to know and what to do.
CalibrationReport describe(const Finding& finding);

/// Places of the field that a camera shows, on a grid.
std::vector<Eigen::Vector2d> places_in_view(const LensCamera& camera, const FieldSize& field);

/// Between where two cameras see the same pixels on the plane z = height, root mean square in mm over places
/// that `now` shows; nothing when `before` shows none of them.
std::optional<double> moved_mm(const LensCamera& before, const LensCamera& now,
                               std::span<const Eigen::Vector2d> places_mm, double height_mm);

}  // namespace sslv
