// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace sslv {

/// A piece of tape or paper on the floor: a rectangle of one colour.
struct Rectangle {
  double x = 0, y = 0;                     // centre, mm
  double half_length = 0, half_width = 0;  // mm
  double angle_rad = 0;                    // direction of its length
};

/// Samples of planes at the same positions.
struct RectangleSamples {
  static constexpr std::size_t kMax = 1024;

  std::size_t count = 0, planes = 0;
  std::array<float, kMax> x, y;                     // mm
  std::array<std::array<float, kMax>, 3> value;     // values of each plane
  std::array<std::array<double, 2>, 2> blur_mm2{};  // covariance of a sample's blur
  /// For each plane: the residual sum of squares.
  std::array<double, 3> left2{};
};

/// Fits a rectangle to all samples, beginning with the position and size of `start` at several angles, and
/// sets left2 of the groups. At least one group must have samples. Allocates nothing.
Rectangle fit_rectangle(const Rectangle& start, std::span<RectangleSamples* const> groups) noexcept;

}  // namespace sslv
