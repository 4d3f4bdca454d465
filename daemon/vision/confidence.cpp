// SPDX-License-Identifier: Apache-2.0
#include "vision/confidence.h"

#include <algorithm>
#include <cmath>

namespace sslv {
namespace {

/// Weight of the region's area. A region may be too large only because of mixed pixels at the rim. This is
/// assumed if a sphere of the known radius explains nearly everything and nothing around the ball has its
/// colour.
double area_counts(const BallEvidence& e) {
  const auto share = [](double x) { return std::clamp(x, 0.0, 1.0); };
  return 0.25 + 0.75 * std::max({share(e.max_alike / 0.4), share(e.radius_off - 1),
                                 share((e.radius_sigma - 0.1) / 0.1), share((0.9 - e.clear_share) / 0.3),
                                 share((0.85 - e.r2) / 0.2)});
}

double logistic(double x) {
  return std::isfinite(x) ? 1 / (1 + std::exp(-std::clamp(x, -30.0, 30.0))) : 0;
}

/// Logit from the ball's whole image: how much of it a sphere explains, and the region's properties.
double looks_like_ball(const BallEvidence& e) {
  const double unexplained = std::clamp(1 - e.r2, std::exp(-4.0), 1.0);
  const double hidden = std::clamp(1 - e.visible_share, 0.0, 0.6);
  const double area = std::log(std::max(e.area_ratio, 1e-3));
  const double contrast = std::clamp(e.contrast / 0.35, 0.05, 1.0);
  // In weak light and in Bayer images, noise leaves much of a true ball unexplained. Then the colour counts,
  // unless the region is larger than a ball, because the position would be wrong.
  const double orange =
      e.is_orange ? std::clamp(0.6 - e.color_off, 0.0, 0.6) * std::clamp(1 - 8 * area, 0.0, 1.0) : 0;
  return -0.6 - 2.9 * std::log(unexplained) - 1.55 * std::log(1 + e.radius_off * e.radius_off) -
         2.7 * e.moved_share - 10 * area_counts(e) * std::max(area, 0.0) + std::min(area, 0.0) -
         2.2 * (1 - e.clear_share) + 11.5 * hidden - 6.8 * std::clamp(e.color_off - 1, 0.0, 4.0) -
         (e.is_orange ? 0 : 1.7) + 6 * std::log(contrast) + 4 * orange;
}

/// Logit from the residuals of a sphere, the outline and the position.
double is_shaped_like_ball(const BallEvidence& e) {
  const double rough = std::log(std::clamp(e.misfit, 0.05, 2.0));
  const double very_rough = std::max(0.0, rough - std::log(0.3));
  const double out_of_round = std::log(1 + e.out_of_round * e.out_of_round);
  const double radius_off = std::log(1 + e.radius_off * e.radius_off);
  const double unsure = std::log(std::clamp(e.radius_sigma, 0.01, 1.0));
  const double area = std::log(std::max(e.area_ratio, 1e-3));
  const double too_large = std::clamp(area, 0.0, 2.0), too_small = std::clamp(-area, 0.0, 2.5);
  const double hidden = std::clamp(1 - e.visible_share, 0.0, 0.6);
  const double contrast = std::log(std::clamp(e.contrast / 0.35, 0.05, 1.5));
  // A ball half hidden by a robot is not rounder than a piece of tape. And if both models explain the image
  // poorly, as for a shining ball, comparing them is meaningless.
  const double tape = std::clamp((e.visible_share - 0.7) / 0.25, 0.0, 1.0) *
                      std::clamp((0.3 - e.misfit) / 0.1, 0.0, 1.0) *
                      (e.is_bayer ? 10 * std::clamp(e.tape_gain + 0.05, 0.0, 1.0)
                                  : 20 * std::clamp(e.tape_gain + 0.1, 0.0, 1.0));
  // Off the field, other objects are likelier than balls.
  const double outside = std::clamp((e.outside_mm - 40) / 100, 0.0, 1.0);
  return 4.1 - 1.04 * rough - 1.05 * very_rough - 5.2 * out_of_round - 1.69 * radius_off - 1.27 * unsure -
         5.18 * area_counts(e) * too_large - 3.29 * too_small + 4.5 * hidden -
         2.50 * std::clamp(e.color_off - 0.3, 0.0, 3.0) - (e.is_orange ? 0 : 3.82) + 3.18 * contrast -
         2.11 * std::clamp(e.max_alike - 0.3, 0.0, 1.0) - 5.36 * outside - tape;
}

}  // namespace

double confidence_of(const RobotEvidence& e) noexcept {
  // Equally clear dots are evidence of a pattern; one good dot among bad ones is not.
  return logistic(12.5 + 1.94 * std::log(e.min_sure + 0.1) - 8.4 * std::log(e.rms_mm + 0.1) +
                  12.7 * e.min_r2 - 15.5 * e.mean_r2 - 4 * e.unproven);
}

double confidence_of(const BallEvidence& e) noexcept {
  const double picture = looks_like_ball(e), shape = is_shaped_like_ball(e);
  return std::isfinite(picture) ? logistic(std::min(shape, picture)) : 0;
}

}  // namespace sslv
