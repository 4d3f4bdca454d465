// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"

#include <array>
#include <cstddef>
#include <string_view>

namespace sslv {

// Written once for vectors of any length (Google Highway); the first call selects the version for the CPU.

/// Grid of samples of up to three colour planes: every step_x (step_y) pixels from first_x (first_y) on. The
/// byte of a plane is at the plane's offset within the bytes_per_step bytes of a sample. One plane uses every
/// second byte, two planes use two of every four bytes, three planes use all bytes.
struct SampleGrid {
  int first_x, first_y, step_x, step_y;
  int bytes_per_step;
  int planes;
  std::array<int, 3> offset;
  float middle_x;  // centre of a sample, relative to its first pixel
  float wide_px;   // width of a sample
};

/// Samples, with their positions relative to a patch's pixel.
struct PlaneSamples {
  static constexpr int kMax = 8192, kPad = 16;  // whole vectors are written, even beyond the last sample
  struct alignas(64) Row : std::array<float, kMax + kPad> {};
  Row u, v;
  std::array<Row, 3> value;  // values of each plane
  Row keep;                  // for sum_ball(): 1, or at most 0 for a sample to be left out
  int planes = 0, count = 0;
};

/// A PlanePatch in single precision: maps displacements in the image to displacements on the plane. Positions
/// in mm are relative to the patch.
struct KernelPatch {
  float xu, xv, xuu, xuv, xvv, yu, yv, yuu, yuv, yvv;
  float u0, v0;  // the patch's pixel
};

/// Reads a grid's samples in and around the circle (x, y, radius) of the plane and appends them to `samples`,
/// which must be empty or hold samples of a grid with the same number of planes. The values are 8-bit levels,
/// with fractions if the image has low bits (only for grids of one plane).
void read_samples(const KernelPatch& patch, float x, float y, float radius, const ImageView& image,
                  const SampleGrid& grid, PlaneSamples& samples) noexcept;

/// A disc whose image is compared with samples; lengths in mm.
struct DiscTemplate {
  KernelPatch patch;
  float x, y, radius, outer_radius;
  float outline_x, outline_y, outline_cos, outline_sin, outline_radius, outline_front;
  float blur_px, wide_px;  // width of a sample
};

/// Sums over the samples within the outer radius and the outline. t is the share of a sample that the disc
/// covers; x and y are the changes of t if the disc moves by 1 mm.
struct DiscSums {
  float xx = 0, xy = 0, yy = 0, xt = 0, yt = 0, x = 0, y = 0, tt = 0, t = 0, n = 0;
  struct Plane {
    float x = 0, y = 0, t = 0, one = 0, square = 0;  // products with the plane's values; sum of squares
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

/// Columns of a ball's model: the derivatives of t (1/mm) for motion in x and y and for the radius; t; t
/// times the surface normal's x, y and upward component; one. t is the share of a sample that the ball
/// covers.
enum BallColumn { kShiftX, kShiftY, kGrow, kCover, kShadeX, kShadeY, kShadeUp, kGround, kBallColumns };
struct BallSums {
  std::array<std::array<float, kBallColumns>, kBallColumns> products{};  // lower triangle: [i][j], j <= i
  struct Plane {
    std::array<float, kBallColumns> with{};  // products with the plane's values
    float square = 0;
  };
  std::array<Plane, 3> planes{};
};
BallSums sum_ball(const BallTemplate& ball, const PlaneSamples& samples) noexcept;

/// Name of the instruction set that these functions use on this CPU.
std::string_view disc_kernel_target();

}  // namespace sslv
