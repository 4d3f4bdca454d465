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

/// How a painted line should look at one of its points.
struct ExpectedLine {
  Eigen::Vector2d pixel, normal;  // normal to the line's image, of length 1
  double width_px = 1;
  double curvature =
      0;  // 1/px: how far the line has bent off its tangent is half of it times distance squared
};

/// Nothing when the camera does not show the point `margin_px` or more inside the image.
std::optional<ExpectedLine> expect_line(const LensCamera& camera, const PaintedCurve& curve,
                                        const CurvePoint& point, double margin_px);

/// Where lines are, to about a pixel: for each point the nearest bright stripe along the normal, no more than
/// `window_px` away. Points without one are left out.
std::vector<Sighting> find_lines(const LinePicture& picture, const LensCamera& camera,
                                 std::span<const PaintedCurve> curves, std::span<const CurvePoint> points,
                                 double window_px);

/// One patch of a line, both of its borders in one fit.
struct MeasuredLine {
  double offset_px = 0;  // of the line's middle along the normal, from where it was expected
  double sigma_px = 0;   // of that, by the image's noise
  double contrast = 0;   // of the paint against its surroundings, in grey levels
  double residual = 0;   // what the fit leaves, root of the mean square
};

/// Length of the patches that lines are measured in.
inline constexpr double kPatchPx = 8;

/// Least squares over all pixels of the patch: an even ground with two slopes and a stripe of known width
/// with edges blurred by a Gaussian of `blur_px`. Nothing without pixels enough or when it finds no stripe
/// near.
std::optional<MeasuredLine> measure_line(const LinePicture& picture, const ExpectedLine& expected,
                                         double blur_px);

}  // namespace sslv
