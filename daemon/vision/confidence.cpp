// SPDX-License-Identifier: Apache-2.0
#include "vision/confidence.h"

#include <algorithm>
#include <cmath>

namespace sslv {
namespace {

double logistic(double x) {
  return std::isfinite(x) ? 1 / (1 + std::exp(-std::clamp(x, -30.0, 30.0))) : 0;
}

}  // namespace

double confidence_of(const RobotEvidence& e) noexcept {
  // Dots that are equally clear speak for a pattern; one good dot among bad ones does not.
  return logistic(12.5 + 1.94 * std::log(e.least_sure + 0.1) - 8.4 * std::log(e.rms_mm + 0.1) +
                  12.7 * e.least_r2 - 15.5 * e.mean_r2 - 4 * e.unproven);
}

double confidence_of(const BallEvidence& e) noexcept {
  const double unexplained = std::clamp(1 - e.r2, std::exp(-4.0), 1.0);
  const double hidden = std::clamp(1 - e.visible_share, 0.0, 0.6);
  const double area = std::log(std::max(e.area_ratio, 1e-3));
  const double contrast = std::clamp(e.contrast / 0.35, 0.05, 1.0);
  // In weak light and in Bayer pictures noise leaves much of a true ball unexplained: its colour counts then,
  // unless the region is more than a ball, whose place would be wrong.
  const double orange =
      e.is_orange ? std::clamp(0.6 - e.color_off, 0.0, 0.6) * std::clamp(1 - 8 * area, 0.0, 1.0) : 0;
  return logistic(-0.6 - 2.9 * std::log(unexplained) - 1.55 * std::log(1 + e.radius_off * e.radius_off) -
                  2.7 * e.moved_share - 10 * std::max(area, 0.0) + 1.9 * std::min(area, 0.0) +
                  6 * std::min(area + 0.6, 0.0) - 2.2 * (1 - e.clear_share) + 11.5 * hidden -
                  6.8 * std::clamp(e.color_off - 1, 0.0, 4.0) - (e.is_orange ? 0 : 1.7) +
                  6 * std::log(contrast) + 4 * orange);
}

}  // namespace sslv
