// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/fit_camera.h"
#include "calibration/line_picture.h"
#include "calibration/painted_curves.h"

#include <cstddef>
#include <span>
#include <stop_token>
#include <vector>

#include <Eigen/Core>

namespace sslv {

/// A camera that shows the given points where they were seen, and how well it suits the image's lines.
struct PoseGuess {
  LensCamera camera;
  std::vector<std::size_t> place_of_pixel;  // index into the places, of each pixel
  double rms_px = 0;                        // of the points
  double evidence = 0;  // 0 .. 1: share of the lines expected in view that lie on bright stripes
};

/// Cameras for which the pixels show some of the places, one each, best evidence first: at least three
/// pixels. Which pixel shows which place is found out when `any_order`; otherwise pixel i shows place i. A
/// camera looks at the field from above, so that mirrored assignments are none. `click_sigma_px` is how exact
/// the pixels are. None once it is told to stop.
std::vector<PoseGuess> guess_poses(std::span<const Eigen::Vector2d> pixels,
                                   std::span<const Eigen::Vector2d> places_mm, bool any_order,
                                   double click_sigma_px, const LinePicture& picture,
                                   std::span<const PaintedCurve> curves, const CameraPrior& prior,
                                   const std::stop_token& stop = {});

/// A camera that shows each place where it was seen, as far as the prior lets it: found from nothing but that
/// it looks down.
CameraFit camera_of_points(std::span<const Eigen::Vector2d> pixels,
                           std::span<const Eigen::Vector2d> places_mm, double sigma_px, int width_px,
                           int height_px, const CameraPrior& prior);

/// Share of the lines expected in view that lie on bright stripes, 0 .. 1; little is seen: less.
double line_evidence(const LensCamera& camera, std::span<const CurvePoint> points,
                     const LinePicture& picture);

/// Points of the lines to look for evidence at.
std::vector<CurvePoint> evidence_points(std::span<const PaintedCurve> curves);

}  // namespace sslv
