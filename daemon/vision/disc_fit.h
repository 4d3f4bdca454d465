// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geometry/plane_patch.h"
#include "image/image.h"

#include <array>
#include <memory>
#include <span>

namespace sslv {

struct PlaneSamples;

/// Blur of a lens in focus, as the sigma of a Gaussian.
inline constexpr double kUsualBlurPx = 0.55;

/// Outline of a robot's black top, which moves with the robot. Only samples within the outline are used.
struct DiscOutline {
  double x_mm = 0, y_mm = 0;  // the robot's centre, relative to the patch
  double cos = 1, sin = 0;    // its heading
  double radius_mm = 1e6, front_mm = 1e6;
};

/// A disc that is expected on the patch's plane.
struct ExpectedDisc {
  double x_mm, y_mm;  // centre, relative to the patch
  double radius_mm;
  double margin_mm;  // width of the sampled ring around the disc
};

/// Sums over the image's samples of a disc and its surroundings (disc_kernel.h), for each colour plane.
struct DiscMeasure {
  struct Plane {
    // Sums of products. t: share of a sample that the disc covers; x, y: change of t if the disc moves by 1
    // mm; v: the sample's value; n: number of samples.
    double xx = 0, xy = 0, yy = 0, xt = 0, yt = 0, x = 0, y = 0, tt = 0, t = 0, n = 0;
    double xv = 0, yv = 0, tv = 0, v = 0, vv = 0;

    /// Adds `weight` virtual samples of the ground with this value.
    void add_ground(double value, double weight);
  };
  std::array<Plane, 3> planes;
  bool yuv = false;      // planes are Y, U, V and not red, green, blue
  bool in_view = false;  // the image has colours and shows the disc
};

/// Result of fitting a disc. The offset of the measured centre from the expected centre is information^-1
/// gradient (mm), with covariance information^-1. The sums over several discs give the fit of a whole
/// pattern.
struct DiscFit {
  double n00 = 0, n01 = 0, n11 = 0;  // information: inverse covariance of the centre, mm^-2
  double g0 = 0, g1 = 0;             // gradient, mm^-1
  std::array<double, 3> contrast{};  // red, green, blue of the disc minus its surroundings
  std::array<double, 3> color{};     // red, green, blue of the disc
  double r2 = 0;                     // share of the samples' variance that a disc there explains
  struct Plane {
    double contrast = 0;  // in the image's own colour space
    double spread = 0;    // sample's noise variance / contrast's variance: equivalent number of samples
    double left = 0;      // residual sum of squares
    double free = 0;      // degrees of freedom
    // Contribution of this plane to information and gradient, times the variance of one sample's noise.
    double n00 = 0, n01 = 0, n11 = 0, g0 = 0, g1 = 0;
  };
  std::array<Plane, 3> planes;
  bool ok = false;  // there were enough samples

  /// Offset of the measured centre from the expected centre; requires ok.
  std::array<double, 2> offset_mm() const {
    const double det = n00 * n11 - n01 * n01;
    return {(n11 * g0 - n01 * g1) / det, (n00 * g1 - n01 * g0) / det};
  }
};

/// One Gauss-Newton step of the maximum-likelihood estimate, which is enough if the start is accurate to 1
/// mm.
DiscFit fit_disc(const DiscMeasure& measure) noexcept;

/// Common ground of several discs, for each plane.
std::array<double, 3> common_ground(std::span<const DiscMeasure> discs) noexcept;

/// Compares the image with a model: a flat, evenly coloured disc on evenly coloured ground, with blurred
/// edges. Uses the raw samples of each colour plane at their own positions, in YUV 4:2:2, RGB and Bayer
/// images, without conversion.
class DiscMeter {
 public:
  DiscMeter();
  ~DiscMeter();

  /// `blur_px` is the lens' blur, as the sigma of a Gaussian. Allocates nothing.
  DiscMeasure measure(const ImageView& image, const PlanePatch& patch, const ExpectedDisc& disc,
                      const DiscOutline& outline, double blur_px) noexcept;

 private:
  struct Work;  // a format's planes, and their samples
  std::unique_ptr<Work> work_;
};

}  // namespace sslv
