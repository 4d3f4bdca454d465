// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/fit_camera.h"
#include "calibration/line_picture.h"
#include "calibration/painted_curves.h"

#include <optional>
#include <span>
#include <stop_token>
#include <vector>

namespace sslv {

/// A camera fitted to the lines of an image, and the fit's quality.
struct RefinedCamera {
  LensCamera camera;
  CameraPrior prior;
  std::vector<Sighting> sightings;                           // sightings used by the fit
  int expected = 0;                                          // line patches in view
  double rms_px = 0;                                         // rms residual of the sightings
  CameraInformation covariance = CameraInformation::Zero();  // for the step's parameters at `camera`

  double found_share() const { return expected > 0 ? static_cast<double>(sightings.size()) / expected : 0; }
  /// Patches found minus patches missing: separates the right camera from a wrong one that fits some lines.
  int score() const { return 2 * static_cast<int>(sightings.size()) - expected; }
};

struct RefineOptions {
  double window_px = 30;    // search distance from the lines' positions predicted by `start`
  bool two_radial = false;  // fit the second radial term too
};

/// Fits all lines in the image, from a camera whose errors are within the window. Returns nothing if too few
/// lines are found, if the camera becomes implausible, or after a stop request.
std::optional<RefinedCamera> refine_camera(const LinePicture& picture, const LensCamera& start,
                                           std::span<const PaintedCurve> curves, const CameraPrior& prior,
                                           const RefineOptions& options, const std::stop_token& stop = {});

/// Like refine_camera(), but without the coarse search, from a camera that refine_camera() fitted to other
/// curves a few millimetres away.
std::optional<RefinedCamera> refine_again(const LinePicture& picture, const LensCamera& start,
                                          std::span<const PaintedCurve> curves, const CameraPrior& prior,
                                          const RefineOptions& options, const std::stop_token& stop = {});

/// Expected RMS error in mm of the position on the plane z = height that a pixel shows; NaN if the ray does
/// not meet the plane.
double expected_error_mm(const RefinedCamera& refined, const Eigen::Vector2d& pixel, double height_mm);

}  // namespace sslv
