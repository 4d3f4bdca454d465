// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"

#include <array>
#include <cstddef>
#include <string_view>

namespace sslv {

// Written once for vectors of any length (Google Highway) and chosen at the first call for the CPU it runs
// on.

/// Samples of up to three colour planes lie on a grid: every step_x (step_y) pixels from first_x (first_y)
/// on. A plane's byte stands at its offset in the bytes_per_step of a sample. One plane has every second
/// byte, two have two of every four, three have all.
struct SampleGrid {
  int first_x, first_y, step_x, step_y;
  int bytes_per_step;
  int planes;
  std::array<int, 3> offset;
  float middle_x;  // of a sample, from its first pixel
  float wide_px;   // how wide a sample is
};

/// Samples that were read, with their places relative to a patch's pixel.
struct PlaneSamples {
  static constexpr int kMax = 8192, kPad = 16;  // whole vectors are written, beyond the last sample
  struct alignas(64) Row : std::array<float, kMax + kPad> {};
  Row u, v;
  std::array<Row, 3> value;  // of each plane
  Row keep;                  // for sum_ball(): 1, or 0 for a sample to be left out
  int planes = 0, count = 0;
};

/// The part of a plane that is shown by a patch's neighbourhood: displacement on the plane for one in the
/// image, as PlanePatch has it; places in mm are relative to the patch.
struct KernelPatch {
  float xu, xv, xuu, xuv, xvv, yu, yv, yuu, yuv, yvv;
  float u0, v0;  // the patch's pixel
};

/// Reads a grid's samples in and around the circle (x, y, radius) of the plane and adds them to `samples`,
/// which must hold none, or those of a grid with as many planes. The values are levels of 8 bits, with
/// fractions where the image has low bits (of one plane's grids).
void read_samples(const KernelPatch& patch, float x, float y, float radius, const ImageView& image,
                  const SampleGrid& grid, PlaneSamples& samples) noexcept;

/// A disc whose image is compared with samples; lengths in mm.
struct DiscTemplate {
  KernelPatch patch;
  float x, y, radius, outer_radius;
  float outline_x, outline_y, outline_cos, outline_sin, outline_radius, outline_front;
  float blur_px, wide_px;  // how wide a sample is
};

/// Sums over the samples within the outer radius and the outline. T is the share of a sample that the disc
/// covers, (x, y) its change as the disc moves by 1 mm.
struct DiscSums {
  float xx = 0, xy = 0, yy = 0, xt = 0, yt = 0, x = 0, y = 0, tt = 0, t = 0, n = 0;
  struct Plane {
    float x = 0, y = 0, t = 0, one = 0, square = 0;  // products with the plane's values, and their squares
  };
  std::array<Plane, 3> planes{};
};
DiscSums sum_disc(const DiscTemplate& disc, const PlaneSamples& samples) noexcept;

/// A sphere whose silhouette is compared with samples; lengths in mm.
struct BallTemplate {
  KernelPatch patch;
  float x, y, radius, outer_radius;
  float mxx, mxy, myy;  // squared distance of a sample's ray from the centre: mxx x^2 + 2 mxy x y + myy y^2
  float blur_px, wide_px;
};

/// The columns of a ball's model: the changes of T as the ball moves by 1 mm in x and y and as its radius
/// grows by 1 mm; T itself, and shaded by the surface's direction x, y and up; one.
enum BallColumn { kMoveX, kMoveY, kGrow, kCover, kShadeX, kShadeY, kShadeUp, kGround, kBallColumns };
struct BallSums {
  std::array<std::array<float, kBallColumns>, kBallColumns> products{};  // lower triangle: [i][j], j <= i
  struct Plane {
    std::array<float, kBallColumns> with{};  // products with the plane's values
    float square = 0;
  };
  std::array<Plane, 3> planes{};
};
BallSums sum_ball(const BallTemplate& ball, const PlaneSamples& samples) noexcept;

/// Name of the instruction set that these use here.
std::string_view disc_kernel_target();

}  // namespace sslv
