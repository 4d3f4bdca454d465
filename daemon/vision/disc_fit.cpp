// SPDX-License-Identifier: Apache-2.0
#include "vision/disc_fit.h"

#include "vision/disc_kernel.h"
#include "vision/sample_planes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace sslv {
namespace {

/// Minimum noise variance: rounding and effects outside the model.
constexpr double kMinVariance = 0.5;
/// A plane with fewer samples, or with fewer samples covered by the disc, is not used.
constexpr double kMinSamples = 3, kMinCovered = 0.25;

/// Results of fitting one plane, except the centre.
struct PlaneFit {
  double contrast = 0, ground = 0, variance = 1, explained = 0, total = 0;
};

/// Fits contrast and ground of one plane by least squares and adds its information about the centre to `out`.
/// Returns false if there are too few samples of the disc or the ground.
bool fit_plane(const DiscMeasure::Plane& s, PlaneFit& fit, DiscFit::Plane& plane, DiscFit& out) {
  const double det = s.tt * s.n - s.t * s.t;
  if (s.n < kMinSamples || s.tt < kMinCovered || det < 1e-2 * s.n) return false;
  fit.contrast = (s.tv * s.n - s.v * s.t) / det;
  fit.ground = (s.v * s.tt - s.tv * s.t) / det;
  const double left = std::max(0.0, s.vv - fit.contrast * s.tv - fit.ground * s.v);
  plane.contrast = fit.contrast;
  plane.spread = det / s.n;
  plane.left = left;
  plane.free = std::max(1.0, s.n - 4);
  fit.variance = std::max(left / plane.free, kMinVariance);
  fit.total = std::max(0.0, s.vv - s.v * s.v / s.n) / fit.variance;
  fit.explained = fit.total - left / fit.variance;
  // The centre's normal equations with contrast and ground eliminated (Schur complement).
  const auto eliminate = [&](double with_t, double with_one) {
    return std::array{(with_t * s.n - with_one * s.t) / det, (with_one * s.tt - with_t * s.t) / det};
  };
  const auto ex = eliminate(s.xt, s.x), ey = eliminate(s.yt, s.y);
  const double a = fit.contrast, weight = 1 / fit.variance;
  plane.n00 = a * a * (s.xx - s.xt * ex[0] - s.x * ex[1]);
  plane.n01 = a * a * (s.xy - s.xt * ey[0] - s.x * ey[1]);
  plane.n11 = a * a * (s.yy - s.yt * ey[0] - s.y * ey[1]);
  plane.g0 = a * (s.xv - a * s.xt - fit.ground * s.x);
  plane.g1 = a * (s.yv - a * s.yt - fit.ground * s.y);
  out.n00 += weight * plane.n00;
  out.n01 += weight * plane.n01;
  out.n11 += weight * plane.n11;
  out.g0 += weight * plane.g0;
  out.g1 += weight * plane.g1;
  return true;
}

}  // namespace

void DiscMeasure::Plane::add_ground(double value, double weight) {
  n += weight;
  v += weight * value;
  vv += weight * value * value;
}

DiscFit fit_disc(const DiscMeasure& measure) noexcept {
  DiscFit out;
  if (!measure.in_view) return out;
  std::array<PlaneFit, 3> fits;
  for (std::size_t p = 0; p < 3; ++p) {
    if (!fit_plane(measure.planes[p], fits[p], out.planes[p], out)) return {};
  }
  double explained = 0, total = 0;
  std::array<double, 3> contrast, color;
  for (std::size_t p = 0; p < 3; ++p) {
    contrast[p] = fits[p].contrast;
    color[p] = fits[p].contrast + fits[p].ground;
    explained += fits[p].explained;
    total += fits[p].total;
  }
  out.r2 = total > 0 ? explained / total : 0;
  out.contrast = measure.yuv ? rgb_of_yuv_contrast(contrast) : contrast;
  out.color = measure.yuv ? rgb_of_yuv_color(color) : color;
  out.ok = out.n00 * out.n11 - out.n01 * out.n01 > 0;
  return out;
}

std::array<double, 3> common_ground(std::span<const DiscMeasure> discs) noexcept {
  std::array<double, 3> out{};
  for (std::size_t p = 0; p < 3; ++p) {
    // Least squares with one common ground and a contrast for each disc; the contrasts are eliminated.
    double sum = 0, weight = 0;
    for (const DiscMeasure& disc : discs) {
      const DiscMeasure::Plane& s = disc.planes[p];
      if (!disc.in_view || s.tt < kMinCovered) continue;
      sum += s.v - s.t * s.tv / s.tt;
      weight += s.n - s.t * s.t / s.tt;
    }
    out[p] = weight > 0 ? sum / weight : 0;
  }
  return out;
}

struct DiscMeter::Work {
  PixelFormat format = PixelFormat::kUyvy;
  SamplePlanes planes = sample_planes(format);
  PlaneSamples samples;
};

DiscMeter::DiscMeter() : work_(std::make_unique<Work>()) {}
DiscMeter::~DiscMeter() = default;

DiscMeasure DiscMeter::measure(const ImageView& image, const PlanePatch& patch, const ExpectedDisc& disc,
                               const DiscOutline& outline, double blur_px) noexcept {
  const auto f = [](double value) { return static_cast<float>(value); };
  DiscTemplate shape{kernel_patch(patch),
                     f(disc.x_mm),
                     f(disc.y_mm),
                     f(disc.radius_mm),
                     f(disc.radius_mm + disc.margin_mm),
                     f(outline.x_mm),
                     f(outline.y_mm),
                     f(outline.cos),
                     f(outline.sin),
                     f(outline.radius_mm),
                     f(outline.front_mm),
                     f(blur_px),
                     1};
  if (work_->format != image.format) {
    work_->format = image.format;
    work_->planes = sample_planes(image.format);
  }
  const SamplePlanes& planes = work_->planes;
  PlaneSamples& samples = work_->samples;
  DiscMeasure out;
  out.yuv = planes.yuv;
  std::size_t next = 0;
  for (const auto& grids : planes.groups) {
    if (grids.empty()) break;
    samples.count = 0;
    for (const SampleGrid& grid : grids)
      read_samples(shape.patch, shape.x, shape.y, shape.outer_radius, image, grid, samples);
    shape.wide_px = grids.front().wide_px;
    const DiscSums s = sum_disc(shape, samples);
    for (std::size_t p = 0; p < static_cast<std::size_t>(grids.front().planes); ++p) {
      const DiscSums::Plane& v = s.planes[p];
      out.planes[next++] = {s.xx, s.xy, s.yy, s.xt, s.yt, s.x,   s.y,     s.tt,
                            s.t,  s.n,  v.x,  v.y,  v.t,  v.one, v.square};
    }
  }
  out.in_view = next == 3;
  return out;
}

}  // namespace sslv
