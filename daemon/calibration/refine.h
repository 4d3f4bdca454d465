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

/// A camera fitted to the lines of an image, and how well.
struct RefinedCamera {
  LensCamera camera;
  CameraPrior prior;
  std::vector<Sighting> sightings;                           // that the fit rests on
  int expected = 0;                                          // patches of lines in view
  double rms_px = 0;                                         // of the sightings
  CameraInformation covariance = CameraInformation::Zero();  // of the step's parameters at the camera

  double found_share() const { return expected > 0 ? static_cast<double>(sightings.size()) / expected : 0; }
  /// Patches found less those missing: what tells a right camera from a wrong one that fits some lines.
  int score() const { return 2 * static_cast<int>(sightings.size()) - expected; }
};

struct RefineOptions {
  double window_px = 30;    // how far lines may be from where `start` has them
  bool two_radial = false;  // fit the second radial term too
};

/// Fits all lines that the image shows, from a camera good to the window. Nothing when too few lines are
/// found or when stopped.
std::optional<RefinedCamera> refine_camera(const LinePicture& picture, const LensCamera& start,
                                           std::span<const PaintedCurve> curves, const CameraPrior& prior,
                                           const RefineOptions& options, const std::stop_token& stop = {});

/// The same from a camera that refine_camera() had fitted to other curves a few millimetres away.
std::optional<RefinedCamera> refine_again(const LinePicture& picture, const LensCamera& start,
                                          std::span<const PaintedCurve> curves, const CameraPrior& prior,
                                          const RefineOptions& options, const std::stop_token& stop = {});

/// Expected error on the plane z = height, root mean square of the distance in mm, at the place a pixel
/// shows.
double expected_error_mm(const RefinedCamera& refined, const Eigen::Vector2d& pixel, double height_mm);

}  // namespace sslv
