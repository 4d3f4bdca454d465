// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/fit_camera.h"
#include "calibration/lens_camera.h"
#include "calibration/line_picture.h"
#include "calibration/painted_curves.h"

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace sslv {

/// Expected image of a painted line at one of its points.
struct ExpectedLine {
  Eigen::Vector2d pixel, normal;  // normal: unit normal of the line's image
  double width_px = 1;
  double curvature = 0;  // 1/px; offset from the tangent = curvature / 2 * distance^2
};

/// Returns nothing unless the point is in the image, at least `margin_px` from its edge.
std::optional<ExpectedLine> expect_line(const LensCamera& camera, const PaintedCurve& curve,
                                        const CurvePoint& point, double margin_px);

/// Finds lines to within about a pixel: for each point, the nearest bright stripe along the normal, at most
/// `window_px` away. Points with no stripe or with too many stripes are left out.
std::vector<Sighting> find_lines(const LinePicture& picture, const LensCamera& camera,
                                 std::span<const PaintedCurve> curves, std::span<const CurvePoint> points,
                                 double window_px);

/// Measurement of one patch of a line. One fit covers both borders.
struct MeasuredLine {
  double offset_px = 0;  // offset of the line's middle along the normal, from its expected position
  double sigma_px = 0;   // sigma of offset_px, due to image noise
  double contrast = 0;   // contrast of the paint to its surroundings, in grey levels
  double residual = 0;   // RMS residual of the fit, in grey levels
};

/// Length of the line patches that are measured.
inline constexpr double kPatchPx = 8;

/// Least-squares fit to all pixels of the patch: a ground with two slopes, and a stripe of known width with
/// edges blurred by a Gaussian of sigma `blur_px`. Returns nothing if the image's edge cuts the patch, if the
/// patch has too few pixels, or if no stripe is near.
std::optional<MeasuredLine> measure_line(const LinePicture& picture, const ExpectedLine& expected,
                                         double blur_px);

}  // namespace sslv
