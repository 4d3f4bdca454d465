// SPDX-License-Identifier: Apache-2.0
#include "calibration/judge.h"

#include <algorithm>
#include <cmath>

namespace sslv {
namespace {

constexpr double kMinCredit = 0.52, kUnexplainedWeight = 4;

double unexplained_share(const LensCamera& camera, const LinePicture& picture,
                         std::span<const PaintedCurve> curves, const FieldSize& field) {
  constexpr double kOnLineMm = 50, kAroundMm = 100;
  const double half_x = field.field_length / 2.0 + kAroundMm, half_y = field.field_width / 2.0 + kAroundMm;
  int all = 0, unexplained = 0;
  for (int y = 0; y < picture.height(); ++y) {
    const float* row = picture.line.row(y);
    for (int x = 0; x < picture.width(); ++x) {
      if (row[x] < picture.min_line) continue;
      const auto place = camera.unproject({x, y}, 0);
      if (!place || std::abs(place->x()) > half_x || std::abs(place->y()) > half_y) continue;
      ++all;
      unexplained += std::none_of(curves.begin(), curves.end(), [&](const PaintedCurve& curve) {
        return curve.distance_mm(*place) < kOnLineMm;
      });
    }
  }
  return all > 0 ? static_cast<double>(unexplained) / all : 0;
}

}  // namespace

double Verdict::credit() const {
  return found_share - kUnexplainedWeight * unexplained_share;
}

double Verdict::max_rms_px() const {
  constexpr double kUnevenMm = 4, kMostPx = 1.5;
  return std::clamp(kUnevenMm * px_per_mm, kMaxRmsPx, kMostPx);
}

bool Verdict::lines_are_found() const {
  return credit() > kMinCredit;
}

Verdict judge(const RefinedCamera& refined, const LinePicture& picture, std::span<const PaintedCurve> curves,
              const FieldSize& field) {
  return {refined.rms_px, refined.found_share(), unexplained_share(refined.camera, picture, curves, field),
          refined.camera.px_per_mm()};
}

}  // namespace sslv
