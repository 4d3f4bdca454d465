// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/calibration_report.h"
#include "calibration/calibration_task.h"
#include "calibration/camera_prior.h"
#include "calibration/judge.h"
#include "calibration/painted_curves.h"
#include "calibration/publish.h"
#include "calibration/refine.h"

#include <optional>
#include <span>
#include <string>
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
  bool either_way_round;  // turned by half a turn it suits the image as well
  bool only_one;          // no other part of the field suits the image
};

/// Figures for people and programs, and in plain words what to know and what to do.
CalibrationReport describe(const Finding& finding);

// What the joint calibration says too.

/// What is wrong with a camera, in plain words; nothing when it is acceptable. `doubt`: what else may have
/// gone wrong with lines that were not found.
std::vector<std::string> problems_of(const Verdict& verdict, const char* doubt);

/// That the wire cannot describe this lens; nothing when it can.
std::optional<std::string> lens_note(const Published& published);

/// That its lines were found to lie as if this field's sizes had been measured to their outer edges.
std::string outer_edge_note(const FieldSize& field);

/// Places of the field that a camera shows, on a grid.
std::vector<Eigen::Vector2d> places_in_view(const LensCamera& camera, const FieldSize& field);

/// Between where two cameras see the same pixels on the plane z = height, root mean square in mm over places
/// that `now` shows; nothing when `before` shows none of them.
std::optional<double> moved_mm(const LensCamera& before, const LensCamera& now,
                               std::span<const Eigen::Vector2d> places_mm, double height_mm);

}  // namespace sslv
