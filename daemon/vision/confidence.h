// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sslv {

// Probability that a detection is right. Both are logistic regressions, fitted to detections in simulated
// images of all the conditions in docs/accuracy.md, where the truth is known: among detections with
// confidence c, a share of about c is right. Results lie in [0, 1] and are never NaN.

/// Evidence that a pattern is the robot it was identified as.
struct RobotEvidence {
  double min_sure = 0;  // least margin times snr among the proven dots (PatternDotFit)
  double rms_mm = 0;    // see PatternFit
  double min_r2 = 0, mean_r2 = 0;
  int unproven = 0;  // number of dots whose colour is not proven but inferred
};
double confidence_of(const RobotEvidence& evidence) noexcept;

/// Evidence that a region is a ball.
struct BallEvidence {
  double r2 = 0;             // see BallFit
  double moved_share = 0;    // distance between region and fit / radius
  double clear_share = 1;    // see BallFit
  double misfit = 1;         // see BallFit
  double out_of_round = 0;   // BallFit::out_of_round_mm / (its sigma and 3.5 % of the radius, in quadrature)
  double radius_off = 0;     // error of the fitted radius / (its sigma and 8 % of the radius, in quadrature)
  double radius_sigma = 1;   // sigma of the fitted radius / radius
  double area_ratio = 1;     // area of the region / area of the ball's visible part
  double visible_share = 1;  // see BallFit
  bool is_orange = true;     // the table's nearest label to the fitted colour is orange
  double color_off = 0;      // see ColorName
  double contrast = 0;       // see BallFit
  double max_alike = 0;      // see BallFit
  double outside_mm = 0;     // distance outside the lines and goals; negative: inside
  /// As BallFitter::rectangle_gain(); lower for balls. The default means unknown.
  double tape_gain = -1;
  bool is_bayer = false;  // samples of each plane are half as dense
};
double confidence_of(const BallEvidence& evidence) noexcept;

}  // namespace sslv
