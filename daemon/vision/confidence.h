// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sslv {

// How likely a detection is right. Both are logistic regressions, fitted to what the detectors find in
// simulated images of all the conditions in docs/accuracy.md, where the truth is known: among detections
// with confidence c, about c are right. Results lie in [0, 1] and are never NaN.

/// What speaks for a pattern being that robot.
struct RobotEvidence {
  double min_sure = 0;  // of the proven dots: the least margin times snr of a colour (PatternDotFit)
  double rms_mm = 0;    // as PatternFit
  double min_r2 = 0, mean_r2 = 0;
  int unproven = 0;  // dots that are not proven: their colours follow from what else is known
};
double confidence_of(const RobotEvidence& evidence) noexcept;

/// What speaks for a region being a ball.
struct BallEvidence {
  double r2 = 0;            // as BallFit
  double moved_share = 0;   // distance between region and fit over the radius
  double clear_share = 1;   // as BallFit
  double misfit = 1;        // as BallFit
  double out_of_round = 0;  // its outline's harmonics over 3.5 % of the radius and their deviation
  double radius_off = 0;    // distance of the best radius from the true one, over 8 % of it and its deviation
  double radius_sigma = 1;  // that deviation over the radius
  double area_ratio = 1;    // the region's area over that of the ball's visible part
  double visible_share = 1;  // as BallFit
  bool is_orange = true;     // no other of the table's colours is nearer to the fitted one
  double color_off = 0;      // as ColorName
  double contrast = 0;       // as BallFit
  double max_alike = 0;      // as BallFit
  double outside_mm = 0;     // how far outside the lines and goals it lies; less than 0: inside
  /// As BallFitter::rectangle_gain(); balls have less. By default nothing is known.
  double tape_gain = -1;
  bool is_bayer = false;  // the planes' samples are half as dense
};
double confidence_of(const BallEvidence& evidence) noexcept;

}  // namespace sslv
