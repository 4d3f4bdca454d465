// SPDX-License-Identifier: Apache-2.0
#include "calibration/choose_model.h"

#include "base/statistics.h"

#include <utility>

namespace sslv {
namespace {

/// The sightings with their field points moved from the curves `from` to the corresponding points of `to`.
std::vector<Sighting> on_curves(std::span<const Sighting> sightings, std::span<const PaintedCurve> from,
                                std::span<const PaintedCurve> to) {
  std::vector<Sighting> out(sightings.begin(), sightings.end());
  for (Sighting& sighting : out) {
    const PaintedCurve &old = from[sighting.curve], &now = to[sighting.curve];
    const Eigen::Vector2d place = sighting.place_mm.head<2>();
    Eigen::Vector2d there;
    if (old.is_arc) {
      there = now.from + now.radius_mm * (place - old.from).normalized();
    } else {
      there = now.point((place - old.from).dot(old.direction(0)) * now.length_mm() / old.length_mm());
    }
    sighting.place_mm = {there.x(), there.y(), 0};
  }
  return out;
}

CameraFit fit(const RefinedCamera& refined, std::span<const Sighting> sightings, bool two_radial) {
  constexpr double kCauchy = 3;
  constexpr int kMaxSteps = 40;
  return fit_camera(refined.camera, sightings, two_radial ? with_second_radial(refined.prior) : refined.prior,
                    {kCauchy, kMaxSteps});
}

/// All cameras, fitted to the lines of one FieldCurves::measured().
struct Fitted {
  std::vector<std::vector<Sighting>> sightings;
  std::vector<CameraFit> fits;
  Rms rms;

  void add(const RefinedCamera& refined, std::vector<Sighting> on_lines) {
    fits.push_back(fit(refined, on_lines, false));
    rms.add(fits.back().rms, static_cast<double>(on_lines.size()));
    sightings.push_back(std::move(on_lines));
  }
};

}  // namespace

CalibrationModel choose_model(std::span<const RefinedCamera> cameras, const FieldCurves& curves,
                              std::optional<LinesMeasured> given) {
  CalibrationModel out;
  out.measured = given.value_or(LinesMeasured::kToMiddle);
  Fitted best;
  for (const RefinedCamera& refined : cameras) best.add(refined, refined.sightings);
  if (!given) {
    constexpr double kClearlyBetter = 0.8;
    Fitted other;
    for (const RefinedCamera& refined : cameras)
      other.add(refined, on_curves(refined.sightings, curves.to_middle, curves.to_outer_edge));
    if (other.rms.value() < kClearlyBetter * best.rms.value()) {
      out.measured = LinesMeasured::kToOuterEdge;
      best = std::move(other);
    }
  }
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    constexpr double kWorthATerm = 0.9;
    const CameraFit two = fit(cameras[i], best.sightings[i], true);
    const bool two_radial = two.rms < kWorthATerm * best.fits[i].rms;
    out.lenses.push_back({two_radial, two_radial ? two.camera : best.fits[i].camera});
  }
  return out;
}

}  // namespace sslv
