// SPDX-License-Identifier: Apache-2.0
#include "colors/swapped_labels.h"

#include <array>
#include <cmath>
#include <numbers>
#include <optional>

namespace sslv {
namespace {

struct PaintHue {
  Label label;
  double deg;  // hue of the paint in white light: angle of (U-128, V-128), as in ColorClass
};
constexpr std::array kPaints{PaintHue{label::kOrange, 128}, PaintHue{label::kYellow, 166},
                             PaintHue{label::kBlue, 329}, PaintHue{label::kPink, 74},
                             PaintHue{label::kGreen, 210}};

/// Lamps and cameras without a white balance shift a hue by less than this.
constexpr double kOtherHue_deg = 60;
/// Smallest length of the mean chroma, relative to the mean length: cells scattered over all colours have no
/// hue.
constexpr double kMinConcentration = 0.5;

double apart_deg(double a_deg, double b_deg) {
  return std::abs(std::remainder(a_deg - b_deg, 360));
}

}  // namespace

std::vector<SwappedLabel> swapped_labels(const ColorTable& table) {
  struct Sum {
    double u = 0, v = 0, length = 0;
  };
  std::array<Sum, label::kMaxCount> sums{};
  for (std::size_t cell = 0; cell < table.labels.size(); ++cell) {
    const Label label = table.labels[cell];
    if (label == label::kClear) continue;
    const Yuv color = table.color_of(cell);
    const double u = color.u - 128.0, v = color.v - 128.0;
    Sum& sum = sums[label];
    sum.u += u;
    sum.v += v;
    sum.length += std::hypot(u, v);
  }
  std::vector<SwappedLabel> out;
  for (const PaintHue& paint : kPaints) {
    const Sum& sum = sums[paint.label];
    if (sum.length == 0 || std::hypot(sum.u, sum.v) < kMinConcentration * sum.length) continue;
    const double hue_deg = std::atan2(sum.v, sum.u) * 180 / std::numbers::pi;
    if (apart_deg(hue_deg, paint.deg) <= kOtherHue_deg) continue;
    std::optional<PaintHue> nearest;
    for (const PaintHue& other : kPaints) {
      if (!nearest || apart_deg(hue_deg, other.deg) < apart_deg(hue_deg, nearest->deg)) nearest = other;
    }
    if (nearest->label != paint.label) out.push_back({paint.label, nearest->label});
  }
  return out;
}

}  // namespace sslv
