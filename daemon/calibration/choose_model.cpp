// SPDX-License-Identifier: Apache-2.0
#include "calibration/choose_model.h"

namespace sslv {
namespace {

/// The same sightings with the places that other curves have there.
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

}  // namespace

FieldCurves::FieldCurves(const FieldSize& field)
    : to_outer_edge(painted_curves(field, LinesMeasured::kToOuterEdge)),
      to_middle(painted_curves(field, LinesMeasured::kToMiddle)) {}

CalibrationModel choose_model(const RefinedCamera& refined, const FieldCurves& curves,
                              std::optional<LinesMeasured> given, const CameraPrior& prior) {
  const auto fit = [&](std::span<const Sighting> sightings, bool two_radial) {
    constexpr double kCauchy = 3;
    constexpr int kMostSteps = 40;
    return fit_camera(refined.camera, sightings, two_radial ? with_second_radial(prior) : prior,
                      {kCauchy, kMostSteps});
  };
  CalibrationModel out;
  out.measured = given.value_or(LinesMeasured::kToOuterEdge);
  std::vector<Sighting> sightings = refined.sightings;
  CameraFit best = fit(sightings, false);
  if (!given) {
    constexpr double kClearlyBetter = 0.8;
    std::vector<Sighting> others = on_curves(sightings, curves.to_outer_edge, curves.to_middle);
    const CameraFit other = fit(others, false);
    if (other.rms < kClearlyBetter * best.rms) {
      out.measured = LinesMeasured::kToMiddle;
      sightings = std::move(others);
      best = other;
    }
  }
  constexpr double kWorthATerm = 0.9;
  const CameraFit two = fit(sightings, true);
  out.two_radial = two.rms < kWorthATerm * best.rms;
  out.camera = out.two_radial ? two.camera : best.camera;
  return out;
}

}  // namespace sslv
