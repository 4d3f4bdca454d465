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

/// Greatest deviation of a published calibration that is good enough.
inline constexpr double kMaxLensMm = 10;

/// A calibration that was found, and the data that describe() needs for its report.
struct Finding {
  const CalibrationTask& task;
  const Clicks& clicks;
  const CameraPrior& prior;
  std::span<const PaintedCurve> curves;
  LinesMeasured measured;
  const RefinedCamera& refined;
  Verdict verdict;
  bool either_way_round;           // also fits when rotated by 180 deg; unknown which is right
  bool only_one;                   // no other part of the field fits the image
  const FieldPreset* other_scale;  // another field fits the image at another scale; null: none
};

/// Makes the report: figures, and notes and problems in plain words.
CalibrationReport describe(const Finding& finding);

// The joint calibration uses the following functions, too.

/// The problems of a camera, in plain words; empty if the camera is acceptable. `doubt`: second possible
/// cause of missing lines, as the end of a question.
std::vector<std::string> problems_of(const Verdict& verdict, const char* doubt);

/// A note that the protocol cannot describe this lens; nothing if it can.
std::optional<std::string> lens_note(const Published& published);

/// A note that the lines' positions match field sizes measured to the lines' outer edges.
std::string outer_edge_note(const FieldSize& field);

/// Grid points of the field (mm) that a camera shows.
std::vector<Eigen::Vector2d> places_in_view(const LensCamera& camera, const FieldSize& field);

/// RMS distance in mm between the points that two cameras see in the same pixels on the plane z = height,
/// over the points in `places_mm` that `now` shows; nothing if `before` shows none of these points.
std::optional<double> moved_mm(const LensCamera& before, const LensCamera& now,
                               std::span<const Eigen::Vector2d> places_mm, double height_mm);

}  // namespace sslv
