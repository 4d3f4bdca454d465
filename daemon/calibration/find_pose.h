// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/fit_camera.h"
#include "calibration/line_picture.h"
#include "calibration/painted_curves.h"

#include <cstddef>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include <Eigen/Core>

namespace sslv {

/// A camera that shows the given points at their pixels, and the quality of its fit to the lines in the
/// image.
struct PoseGuess {
  LensCamera camera;
  std::vector<std::size_t> place_of_pixel;  // for each pixel, index into the places
  double rms_px = 0;                        // rms residual of the points
  double evidence = 0;  // 0 .. 1: share of the lines expected in view that lie on bright stripes
};

/// Cameras for which each pixel shows a different place, best evidence first. Needs at least three pixels.
/// `names_known`: pixel i shows place i; otherwise also searches for the assignment, of up to 30 places. The
/// cameras are above the field, so mirrored assignments are rejected. `click_sigma_px`: accuracy of the
/// pixels. Empty after a stop request.
std::vector<PoseGuess> guess_poses(std::span<const Eigen::Vector2d> pixels,
                                   std::span<const Eigen::Vector2d> places_mm, bool names_known,
                                   double click_sigma_px, const LinePicture& picture,
                                   std::span<const PaintedCurve> curves, const CameraPrior& prior,
                                   const std::stop_token& stop = {});

/// Fits a camera to three or more points and the prior. None if no camera above the field shows three of
/// them.
std::optional<CameraFit> camera_of_points(std::span<const Eigen::Vector2d> pixels,
                                          std::span<const Eigen::Vector2d> places_mm, double sigma_px,
                                          int width_px, int height_px, const CameraPrior& prior);

/// Share of the lines expected in view that lie on bright stripes, 0 .. 1; reduced if few points are in view.
double line_evidence(const LensCamera& camera, std::span<const CurvePoint> points,
                     const LinePicture& picture);

/// Points of the lines for line_evidence().
std::vector<CurvePoint> evidence_points(std::span<const PaintedCurve> curves);

}  // namespace sslv
