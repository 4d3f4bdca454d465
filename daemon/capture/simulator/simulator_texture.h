// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/simulator/simulator_random.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace sslv {

/// A value in [-0.5, 0.5] for each corner of a lattice.
inline float lattice_value(double column, double row, std::uint64_t layer) {
  const auto i = static_cast<std::uint64_t>(static_cast<std::int64_t>(column));
  const auto j = static_cast<std::uint64_t>(static_cast<std::int64_t>(row));
  return static_cast<float>(scatter((i << 32) ^ (j & 0xffffffffU) ^ (layer << 60)) >> 40) * 0x1p-24F - 0.5F;
}

/// Noise in [-0.5, 0.5] on a lattice of spacing `cell_mm`, interpolated linearly or, if `smooth`, without
/// edges. Layers (below 16) are independent.
inline float lattice_noise(double x_mm, double y_mm, double cell_mm, std::uint64_t layer,
                           bool smooth = false) {
  const double x = x_mm / cell_mm, y = y_mm / cell_mm;
  const double x0 = std::floor(x), y0 = std::floor(y);
  auto fx = static_cast<float>(x - x0), fy = static_cast<float>(y - y0);
  if (smooth) fx *= fx * (3 - 2 * fx), fy *= fy * (3 - 2 * fy);
  return (lattice_value(x0, y0, layer) * (1 - fx) + lattice_value(x0 + 1, y0, layer) * fx) * (1 - fy) +
         (lattice_value(x0, y0 + 1, layer) * (1 - fx) + lattice_value(x0 + 1, y0 + 1, layer) * fx) * fy;
}

/// Patches of about `size_mm`: mean 0, standard deviation 1, limited to [-3, 3].
inline float patches(double x_mm, double y_mm, double size_mm, std::uint64_t layer) {
  // Two lattices, the finer one rotated, so that no lattice is visible.
  const double u_mm = 0.8 * x_mm + 0.6 * y_mm, v_mm = -0.6 * x_mm + 0.8 * y_mm;
  const float sum = lattice_noise(x_mm, y_mm, size_mm, layer, true) +
                    0.6F * lattice_noise(u_mm, v_mm, 0.43 * size_mm, layer, true);
  constexpr float kDeviation = 0.248F;
  return std::clamp(sum / kDeviation, -3.0F, 3.0F);
}

/// A smooth step from 0 at `from` to 1 at `to`.
inline float smooth_step(float from, float to, float value) {
  const float t = std::clamp((value - from) / (to - from), 0.0F, 1.0F);
  return t * t * (3 - 2 * t);
}

}  // namespace sslv
