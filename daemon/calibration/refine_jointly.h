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

/// Something that two cameras saw at the same moment at a known height: a robot's centre, a ball.
struct OverlapTie {
  std::size_t camera_a, camera_b;
  Eigen::Vector2d pixel_a, pixel_b;
  double height_mm = 0;
  double sigma_px = 0.3;
};

/// How far apart two cameras have the same paint, across the line, wherever both see it. `cameras` may be
/// others than `seen` was fitted to.
std::vector<double> disagreements_mm(std::span<const LensCamera> cameras, std::span<const RefinedCamera> seen,
                                     std::span<const PaintedCurve> curves);

struct JointCalibration {
  std::vector<LensCamera> cameras;
  /// Where one camera has a painted line and where the other has it, across the line: root mean square over
  /// the overlap, in mm. 0 without overlap.
  double disagreement_before_mm = 0, disagreement_mm = 0;
  int overlapping_patches = 0;
};

/// Cameras that see the same lines and things, refined each by itself, are fitted together: lines may lie a
/// little off their places, but then for all cameras alike (bundle adjustment; Triggs et al. 2000). All
/// cameras' sightings must be of `curves`. `stop` ends it early, with cameras that are fitted in part.
JointCalibration refine_jointly(std::span<const RefinedCamera> cameras, std::span<const PaintedCurve> curves,
                                std::span<const OverlapTie> ties, const std::stop_token& stop = {});

}  // namespace sslv
