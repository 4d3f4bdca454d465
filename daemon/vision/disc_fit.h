// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geometry/plane_patch.h"
#include "image/image.h"

#include <array>
#include <memory>
#include <span>

namespace sslv {

struct PlaneSamples;

/// Where samples are of use: within an outline that moves with a robot. Beyond it lies what is not the
/// robot's black top.
struct DiscOutline {
  double x_mm = 0, y_mm = 0;  // the robot's centre, relative to the patch
  double cos = 1, sin = 0;    // its heading
  double radius_mm = 1e6, front_mm = 1e6;
};

/// A disc that is expected on the patch's plane.
struct ExpectedDisc {
  double x_mm, y_mm;  // centre, relative to the patch
  double radius_mm;
  double margin_mm;  // width of the ring around it that is looked at too
};

/// The image's samples about a disc, summed up (disc_kernel.h), for each colour plane.
struct DiscMeasure {
  struct Plane {
    // T: share of a sample that the disc covers; x, y: its change as the disc moves by 1 mm; v: the sample.
    double xx = 0, xy = 0, yy = 0, xt = 0, yt = 0, x = 0, y = 0, tt = 0, t = 0, n = 0;
    double xv = 0, yv = 0, tv = 0, v = 0, vv = 0;

    /// As if there were `weight` more samples of the ground, all of that value.
    void add_ground(double value, double weight);
  };
  std::array<Plane, 3> planes;
  bool yuv = false;      // planes are Y, U, V and not red, green, blue
  bool in_view = false;  // the image has colours, and the disc is in it
};

/// What the image says about a disc. The measured centre lies information^-1 gradient (mm) away from the
/// expected one, with covariance information^-1; fits of several discs add up to that of a whole pattern.
struct DiscFit {
  double n00 = 0, n01 = 0, n11 = 0;  // information: inverse covariance of the centre, mm^-2
  double g0 = 0, g1 = 0;             // gradient, mm^-1
  std::array<double, 3> contrast{};  // red, green, blue of the disc less its surroundings
  std::array<double, 3> color{};     // red, green, blue of the disc
  double r2 = 0;                     // share of the samples' variance that a disc there explains
  struct Plane {
    double contrast = 0;  // in the image's own colours
    double spread = 0;    // inverse variance of that, over one sample's: how many samples it is worth
    double left = 0;      // sum of squares that is left unexplained
    double free = 0;      // samples beyond the model's own numbers
    // What this plane adds to information and gradient, times the variance of one sample's noise.
    double n00 = 0, n01 = 0, n11 = 0, g0 = 0, g1 = 0;
  };
  std::array<Plane, 3> planes;
  bool ok = false;  // there were samples enough

  /// Where the disc itself says it is, from the expected place; needs ok.
  std::array<double, 2> offset_mm() const {
    const double det = n00 * n11 - n01 * n01;
    return {(n11 * g0 - n01 * g1) / det, (n00 * g1 - n01 * g0) / det};
  }
};

/// One Gauss-Newton step of the maximum-likelihood estimate; with a start good to 1 mm it is all that is
/// needed.
DiscFit fit_disc(const DiscMeasure& measure) noexcept;

/// The ground that several discs have in common, for each plane.
std::array<double, 3> common_ground(std::span<const DiscMeasure> discs) noexcept;

/// Compares the image with that of a flat, evenly coloured disc on an evenly coloured ground, edge blur
/// included: the raw samples of each colour plane at their own places, of YUV 4:2:2, RGB and Bayer images,
/// without converting them.
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
