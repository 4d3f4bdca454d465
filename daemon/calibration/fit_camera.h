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

/// A place of the field that was seen somewhere: at a point, or somewhere on a line.
struct Sighting {
  Eigen::Vector3d place_mm;
  Eigen::Vector2d pixel;
  std::optional<Eigen::Vector2d> normal;  // of the line, of length 1; none: at the point
  double sigma_px = 1;
  std::size_t curve = 0;  // the painted line it belongs to
};

using CameraInformation = Eigen::Matrix<double, kCameraParams, kCameraParams>;

struct CameraFit {
  LensCamera camera;
  double cost = 0;  // half the sum of squares, priors included
  CameraInformation by_sightings = CameraInformation::Zero(), by_prior = CameraInformation::Zero();
  double rms = 0;  // of the sightings, in their sigmas
};

struct FitOptions {
  /// Sightings this many sigmas off count little (Cauchy's loss); 0: all count by their square.
  double cauchy = 0;
  int max_steps = 40;
};

/// The likeliest camera: Levenberg and Marquardt's method (MINPACK's, as in Eigen), started from `start`.
CameraFit fit_camera(const LensCamera& start, std::span<const Sighting> sightings, const CameraPrior& prior,
                     const FitOptions& options = {});

/// What each sighting is off, in sigmas: along the normal, or the distance.
std::vector<double> residuals(const LensCamera& camera, std::span<const Sighting> sightings);
/// The same in pixels.
std::vector<double> residuals_px(const LensCamera& camera, std::span<const Sighting> sightings);

/// Change of each line sighting's residual by the camera's parameters (rows), at the camera.
Eigen::Matrix<double, Eigen::Dynamic, kCameraParams> residuals_by_step(const LensCamera& camera,
                                                                       std::span<const Sighting> sightings);

}  // namespace sslv
