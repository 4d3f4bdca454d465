// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/camera_prior.h"
#include "calibration/lens_camera.h"

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace sslv {

/// A point of the field seen in the image: at `pixel`, or anywhere on the line through `pixel`.
struct Sighting {
  Eigen::Vector3d place_mm;
  Eigen::Vector2d pixel;
  std::optional<Eigen::Vector2d> normal;  // unit normal of the line; none: seen at `pixel`
  double sigma_px = 1;
  std::size_t curve = 0;  // index of the painted line it belongs to
};

using CameraInformation = Eigen::Matrix<double, kCameraParams, kCameraParams>;

struct CameraFit {
  LensCamera camera;
  double cost = 0;  // half the sum of squares, priors included
  CameraInformation by_sightings = CameraInformation::Zero(), by_prior = CameraInformation::Zero();
  double rms = 0;  // rms residual of the sightings, in sigmas
};

struct FitOptions {
  /// Scale of the Cauchy loss in sigmas: larger residuals count little. 0: least squares.
  double cauchy = 0;
  int max_steps = 40;
};

/// Maximum a posteriori camera, by Levenberg-Marquardt (MINPACK's, as in Eigen) from `start`.
CameraFit fit_camera(const LensCamera& start, std::span<const Sighting> sightings, const CameraPrior& prior,
                     const FitOptions& options = {});

/// Residual of each sighting in sigmas: along its normal, or the distance if the sighting has no normal. 1000
/// for a place that the camera cannot show.
std::vector<double> residuals(const LensCamera& camera, std::span<const Sighting> sightings);
/// Like residuals(), in pixels.
std::vector<double> residuals_px(const LensCamera& camera, std::span<const Sighting> sightings);

/// Jacobian of the line sightings' residuals (in sigmas) with respect to the step parameters, at `camera`:
/// one row per sighting, 0 for point sightings and places not shown.
Eigen::Matrix<double, Eigen::Dynamic, kCameraParams> residuals_by_step(const LensCamera& camera,
                                                                       std::span<const Sighting> sightings);

}  // namespace sslv
