// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/fit_camera.h"
#include "calibration/painted_curves.h"
#include "calibration/refine.h"

#include <cstddef>
#include <span>
#include <stop_token>
#include <vector>

namespace sslv {

/// A tie point: an object of known height that two cameras saw at the same moment (a robot's centre, a ball).
struct OverlapTie {
  std::size_t camera_a, camera_b;
  Eigen::Vector2d pixel_a, pixel_b;
  double height_mm = 0;
  double sigma_px = 0.3;
};

/// Signed distances in mm, across the line, between the positions that two cameras give for the same paint,
/// at all places that both cameras see. `cameras` may differ from the cameras in `seen`.
std::vector<double> disagreements_mm(std::span<const LensCamera> cameras, std::span<const RefinedCamera> seen,
                                     std::span<const PaintedCurve> curves);

struct JointCalibration {
  std::vector<LensCamera> cameras;
  /// RMS over the overlap, in mm, of the distance across a painted line between the positions that two
  /// cameras give for the line. 0 without overlap.
  double disagreement_before_mm = 0, disagreement_mm = 0;
  int overlapping_patches = 0;
};

/// Jointly fits cameras that were refined one by one and that see the same lines and objects. Lines may
/// deviate a little from their positions, but equally for all cameras (bundle adjustment; Triggs et al.
/// 2000). All cameras' sightings must refer to `curves`. A stop request ends the fit early, with partly
/// fitted cameras.
JointCalibration refine_jointly(std::span<const RefinedCamera> cameras, std::span<const PaintedCurve> curves,
                                std::span<const OverlapTie> ties, const std::stop_token& stop = {});

}  // namespace sslv
