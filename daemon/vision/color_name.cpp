// SPDX-License-Identifier: Apache-2.0
#include "vision/color_name.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace sslv {
namespace {

using Chromaticity = std::array<double, 3>;

Chromaticity chromaticity_of(const std::array<double, 3>& contrast) {
  Chromaticity out{};
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) sum += out[i] = std::max(0.0, contrast[i]);
  for (double& share : out) share = sum > 0 ? share / sum : 1.0 / 3;
  return out;
}

double squared_distance(const Chromaticity& a, const Chromaticity& b) {
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

/// Distance that ignores higher purity: a purer colour of the same hue is the same print with less white in
/// its light.
double distance_unless_purer(const Chromaticity& seen, const Chromaticity& known) {
  Chromaticity away, purer;  // vector from `known` to `seen`; vector from grey to `known`
  double along = 0, length2 = 0, distance2 = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    away[i] = seen[i] - known[i];
    purer[i] = known[i] - 1.0 / 3;
    along += away[i] * purer[i];
    length2 += purer[i] * purer[i];
    distance2 += away[i] * away[i];
  }
  if (along > 0 && length2 > 0) distance2 -= along * along / length2;
  return std::sqrt(std::max(0.0, distance2));
}

}  // namespace

std::array<double, 3> unclipped(const std::array<double, 3>& contrast, const std::array<double, 3>& color,
                                const std::array<double, 3>& chromaticity) noexcept {
  constexpr double kMaxTimes = 2;  // without a limit, overexposed white could match any colour
  double along = 0, length2 = 0;
  bool any_clipped = false;
  for (std::size_t i = 0; i < 3; ++i) {
    if (color[i] >= kClippedGrey) {
      any_clipped = true;
      continue;
    }
    along += std::max(0.0, contrast[i]) * chromaticity[i];
    length2 += chromaticity[i] * chromaticity[i];
  }
  std::array<double, 3> out = contrast;
  if (!any_clipped || length2 <= 0) return out;
  for (std::size_t i = 0; i < 3; ++i) {
    if (color[i] >= kClippedGrey && contrast[i] > 0)
      out[i] = std::clamp(along / length2 * chromaticity[i], contrast[i], kMaxTimes * contrast[i]);
  }
  return out;
}

ColorName name_color(const std::array<double, 3>& contrast, const std::array<double, 3>& color,
                     const Lut& lut, std::span<const Label> allowed) noexcept {
  ColorName out;
  const auto seen_as = [&](Label label) {
    return chromaticity_of(unclipped(contrast, color, lut.chromaticity_mean(label)));
  };
  double best = 1e9, second = 1e9;
  Label best_color = label::kClear, second_color = label::kClear;
  for (const Label label : allowed) {
    const double distance = squared_distance(seen_as(label), lut.chromaticity_mean(label));
    if (distance < best) {
      second = best;
      second_color = best_color;
      best = distance;
      best_color = label;
    } else if (distance < second) {
      second = distance;
      second_color = label;
    }
  }
  out.color = best_color;
  out.margin = 1;
  constexpr double kMinSpread = 0.02;
  out.off = distance_unless_purer(seen_as(best_color), lut.chromaticity_mean(best_color)) /
            std::max(lut.chromaticity_spread(best_color), kMinSpread);
  if (second_color != label::kClear) {
    // Position along the line between the chromaticities of both labels: 0 at its middle, 1 at the best
    // label.
    const double apart =
        squared_distance(lut.chromaticity_mean(best_color), lut.chromaticity_mean(second_color));
    // A clipped colour may match one label exactly and be nearer to the other label than the labels are to
    // each other.
    constexpr double kMinApart = 0.2;
    const double both = std::max(std::sqrt(best) + std::sqrt(second), kMinApart);
    out.margin = apart > 0 ? (second - best) / std::min(apart, both * both) : 0;
  }
  const auto byte = [](double value) {
    return static_cast<std::uint8_t>(std::clamp(value + 0.5, 0.0, 255.0));
  };
  const Label in_table = lut.of_rgb(byte(color[0]), byte(color[1]), byte(color[2]));
  const bool contradicts =
      in_table != best_color && std::find(allowed.begin(), allowed.end(), in_table) != allowed.end();
  if (contradicts) out.margin = -out.margin;
  return out;
}

}  // namespace sslv
