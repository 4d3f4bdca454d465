// SPDX-License-Identifier: Apache-2.0
#include "calibration/refine.h"

#include "base/statistics.h"
#include "calibration/measure_lines.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <Eigen/Dense>

namespace sslv {
namespace {

constexpr std::size_t kMinSightings = 12;
constexpr double kEdgeMarginPx = 9;

/// Standard deviation of normally distributed values, from the median of their magnitudes.
double robust_sigma(std::vector<double> values) {
  for (double& value : values) value = std::abs(value);
  return median(std::move(values)) / 0.6745;
}

/// Fits the lines to within about a pixel. The window narrows as the camera improves.
std::optional<LensCamera> fit_roughly(const LinePicture& picture, const LensCamera& start,
                                      std::span<const PaintedCurve> curves, CameraPrior prior,
                                      double window_px, const std::stop_token& stop) {
  // Coarse measurements hardly determine the focal length and may move it far along the valley of the cost,
  // from where it returns slowly. Therefore tighten its prior.
  prior.focal_share = std::min(prior.focal_share, 0.15);
  constexpr double kStepPx = 9, kClearPx = 6, kNarrowing = 0.72, kMinWindowPx = 3;
  constexpr double kCauchyShare = 0.22, kMinCauchyPx = 0.7;
  constexpr int kMinPasses = 9, kMaxPasses = 16;
  LensCamera camera = start;
  const double scale = start.px_per_mm();
  const auto points = points_along(curves, kStepPx / scale, kClearPx / scale + 10);
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    if (stop.stop_requested() || !is_plausible(camera)) return std::nullopt;
    const auto sightings = find_lines(picture, camera, curves, points, window_px);
    if (sightings.size() < kMinSightings) return std::nullopt;
    const LensCamera last = camera;
    camera =
        fit_camera(camera, sightings, prior, {std::max(kMinCauchyPx, kCauchyShare * window_px), 8}).camera;
    if (window_px <= kMinWindowPx) {
      const auto before = last.unproject({last.center_x, last.center_y}, 0),
                 now = camera.unproject({camera.center_x, camera.center_y}, 0);
      const bool still = before && now && (*before - *now).norm() * scale < 0.1;
      if (pass >= kMinPasses || still) break;
    }
    window_px = std::max(kMinWindowPx, kNarrowing * window_px);
  }
  return camera;
}

struct Patches {
  std::vector<Sighting> sightings;
  int expected = 0;
};

/// Measures all patches and keeps those that look like lines.
Patches measure_patches(const LinePicture& picture, const LensCamera& camera,
                        std::span<const PaintedCurve> curves, std::span<const CurvePoint> points,
                        double blur_px, double* median_residual = nullptr) {
  constexpr double kMinSignal = 3;  // contrast in sigmas of the noise
  constexpr double kMinContrastShare = 0.4, kMaxResidualShare = 2.5, kResidualOfContrast = 0.02;
  Patches out;
  std::vector<double> contrasts, rests;
  for (const CurvePoint& point : points) {
    const auto expected = expect_line(camera, curves[point.curve], point, kEdgeMarginPx);
    if (!expected) continue;
    ++out.expected;
    const auto measured = measure_line(picture, *expected, blur_px);
    if (!measured || measured->contrast < kMinSignal * picture.noise) continue;
    Sighting& sighting = out.sightings.emplace_back();
    sighting.place_mm = point.place_mm;
    sighting.pixel = expected->pixel + measured->offset_px * expected->normal;
    sighting.normal = expected->normal;
    constexpr double kMinSigmaPx = 0.004;
    sighting.sigma_px = std::max(kMinSigmaPx, measured->sigma_px);
    sighting.curve = point.curve;
    contrasts.push_back(measured->contrast);
    rests.push_back(measured->residual);
  }
  const double contrast = median(contrasts), rest = median(rests);
  if (median_residual != nullptr) *median_residual = rest;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < out.sightings.size(); ++i) {
    if (contrasts[i] > kMinContrastShare * contrast &&
        rests[i] < kMaxResidualShare * rest + kResidualOfContrast * contrast)
      out.sightings[kept++] = out.sightings[i];
  }
  out.sightings.resize(kept);
  return out;
}

/// Blur of the image in px: the value with the smallest residuals of the lines.
double blur_of(const LinePicture& picture, const LensCamera& camera, std::span<const PaintedCurve> curves,
               std::span<const CurvePoint> points) {
  constexpr std::size_t kSome = 80;
  std::vector<CurvePoint> some;
  const std::size_t step = std::max<std::size_t>(1, points.size() / kSome);
  for (std::size_t i = 0; i < points.size(); i += step) some.push_back(points[i]);
  double best = 0.7, least = std::numeric_limits<double>::infinity();
  for (const double blur_px : {0.5, 0.7, 1.0, 1.4, 2.0}) {
    double rest = 0;
    const Patches patches = measure_patches(picture, camera, curves, some, blur_px, &rest);
    if (patches.sightings.size() < kMinSightings || rest >= least) continue;
    least = rest;
    best = blur_px;
  }
  return best;
}

/// Number of neighbouring sightings that carry as much information as one independent sighting: errors on an
/// unevenly painted line are correlated (first-order autoregression; Bartlett 1935).
double redundancy(const LensCamera& camera, std::span<const Sighting> sightings, double step_mm) {
  const std::vector<double> off = residuals(camera, sightings);
  double together = 0, squares = 0;
  for (std::size_t i = 1; i < off.size(); ++i) {
    const bool neighbours = sightings[i].curve == sightings[i - 1].curve &&
                            (sightings[i].place_mm - sightings[i - 1].place_mm).norm() < 2.5 * step_mm;
    if (!neighbours) continue;
    together += off[i] * off[i - 1];
    squares += 0.5 * (off[i] * off[i] + off[i - 1] * off[i - 1]);
  }
  const double correlation = squares > 0 ? std::clamp(together / squares, 0.0, 0.98) : 0;
  return (1 + correlation) / (1 - correlation);
}

/// Covariance of the parameters, from the change of the camera when one line is left out (jackknife over
/// lines). Patches of a line share the line's errors, so the scatter of the patches would greatly
/// underestimate the covariance.
CameraInformation covariance_of(const LensCamera& camera, std::span<const Sighting> sightings,
                                const CameraInformation& by_prior) {
  const auto changes = residuals_by_step(camera, sightings);
  const std::vector<double> off = residuals(camera, sightings);
  struct Line {
    CameraInformation information = CameraInformation::Zero();
    CameraStep gradient = CameraStep::Zero();
  };
  std::map<std::size_t, Line> lines;
  CameraInformation by_sightings = CameraInformation::Zero();
  double squares = 0;
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    const CameraStep change = changes.row(static_cast<Eigen::Index>(i)).transpose();
    Line& line = lines[sightings[i].curve];
    line.information += change * change.transpose();
    line.gradient += off[i] * change;
    by_sightings += change * change.transpose();
    squares += off[i] * off[i];
  }
  const CameraInformation all = by_sightings + by_prior;
  const double variance = squares / std::max(1.0, static_cast<double>(sightings.size()) - 9);
  const CameraInformation inverse = all.inverse();
  CameraInformation out = inverse * (0.5 * variance * by_sightings + by_prior) * inverse;
  const auto count = static_cast<double>(lines.size());
  for (const auto& [curve, line] : lines) {
    const CameraStep moved_by = (all - line.information).ldlt().solve(line.gradient);
    if (moved_by.allFinite()) out += (count - 1) / count * moved_by * moved_by.transpose();
  }
  return out;
}

}  // namespace

std::optional<RefinedCamera> refine_camera(const LinePicture& picture, const LensCamera& start,
                                           std::span<const PaintedCurve> curves, const CameraPrior& prior,
                                           const RefineOptions& options, const std::stop_token& stop) {
  const auto rough = fit_roughly(picture, start, curves, prior, options.window_px, stop);
  if (!rough) return std::nullopt;
  return refine_again(picture, *rough, curves, prior, options, stop);
}

std::optional<RefinedCamera> refine_again(const LinePicture& picture, const LensCamera& start,
                                          std::span<const PaintedCurve> curves,
                                          const CameraPrior& given_prior, const RefineOptions& options,
                                          const std::stop_token& stop) {
  if (!is_plausible(start)) return std::nullopt;
  const CameraPrior prior = options.two_radial ? with_second_radial(given_prior) : given_prior;
  const double scale = start.px_per_mm();
  const auto points = points_along(curves, kPatchPx / scale, (kPatchPx / 2 + 4) / scale + 10);
  const double blur_px = blur_of(picture, start, curves, points);

  constexpr int kPasses = 3;
  constexpr double kFirstScalePx = 0.5, kMinScalePx = 0.01, kCauchy = 3, kMaxSigmas = 4.5;
  RefinedCamera out;
  out.prior = prior;
  out.camera = start;
  for (int pass = 0; pass < kPasses; ++pass) {
    if (stop.stop_requested() || !is_plausible(out.camera)) return std::nullopt;
    Patches patches = measure_patches(picture, out.camera, curves, points, blur_px);
    if (patches.sightings.size() < kMinSightings) return std::nullopt;
    const double spread_px =
        pass == 0 ? kFirstScalePx
                  : std::max(kMinScalePx, robust_sigma(residuals_px(out.camera, patches.sightings)));
    for (Sighting& sighting : patches.sightings) sighting.sigma_px = std::hypot(sighting.sigma_px, spread_px);
    out.camera = fit_camera(out.camera, patches.sightings, prior, {kCauchy, 30}).camera;
    out.sightings = std::move(patches.sightings);
    out.expected = patches.expected;
  }
  if (stop.stop_requested()) return std::nullopt;
  // Weight sightings by their true spread and drop outliers.
  const double spread_px = std::max(kMinScalePx / 2, robust_sigma(residuals_px(out.camera, out.sightings)));
  for (Sighting& sighting : out.sightings) sighting.sigma_px = spread_px;
  const std::vector<double> off = residuals(out.camera, out.sightings);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < off.size(); ++i) {
    if (std::abs(off[i]) < kMaxSigmas) out.sightings[kept++] = out.sightings[i];
  }
  out.sightings.resize(kept);
  if (kept < kMinSightings) return std::nullopt;
  out.camera = fit_camera(out.camera, out.sightings, prior, {kCauchy, 40}).camera;
  const double fewer = std::sqrt(redundancy(out.camera, out.sightings, kPatchPx / scale));
  for (Sighting& sighting : out.sightings) sighting.sigma_px = fewer * spread_px;
  const CameraFit fit = fit_camera(out.camera, out.sightings, prior, {kCauchy, 40});
  out.camera = fit.camera;
  out.rms_px = fit.rms * fewer * spread_px;
  out.covariance = covariance_of(out.camera, out.sightings, fit.by_prior);
  return out;
}

double expected_error_mm(const RefinedCamera& refined, const Eigen::Vector2d& pixel, double height_mm) {
  constexpr double kStep = 1e-5;
  Eigen::Matrix<double, 2, kCameraParams> by_step;
  for (int i = 0; i < kCameraParams; ++i) {
    CameraStep step = CameraStep::Zero();
    step[i] = kStep;
    const auto plus = moved(refined.camera, step).unproject(pixel, height_mm),
               minus = moved(refined.camera, -step).unproject(pixel, height_mm);
    if (!plus || !minus) return std::numeric_limits<double>::quiet_NaN();
    by_step.col(i) = (*plus - *minus) / (2 * kStep);
  }
  return std::sqrt(std::max(0.0, (by_step * refined.covariance * by_step.transpose()).trace()));
}

}  // namespace sslv
