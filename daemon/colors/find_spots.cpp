// SPDX-License-Identifier: Apache-2.0
#include "colors/find_spots.h"

#include <algorithm>
#include <cmath>

namespace sslv {
namespace {

/// Half sides of the squares that approximate a disc and the ring around it, in radii of the disc.
constexpr double kCore = 0.62, kRingFrom = 1.25, kRingTo = 1.75;
constexpr double kMinDeviations = 4, kMinGrey = 1.5;
/// Minimum number of cells per radius; cell sizes are rounded down.
constexpr double kCellsPerRadius = 2.4;

}  // namespace

int cell_px_for(PixelFormat format, double radius_px) {
  const int even = 2 * static_cast<int>(radius_px / kCellsPerRadius / 2);
  if (is_bayer(format)) return std::max(2, even);
  return std::max(1, even);
}

std::vector<Spot> find_spots(const SmallPicture& picture, double radius_px, double noise_grey, SpotsOf kind,
                             std::size_t most) {
  const double radius = radius_px / picture.cell_px();
  const int core = std::max(0, static_cast<int>(std::lround(kCore * radius - 0.5)));
  const int inner = std::max(core + 1, static_cast<int>(std::lround(kRingFrom * radius - 0.5)));
  const int outer = std::max(inner + 1, static_cast<int>(std::lround(kRingTo * radius - 0.5)));
  const int width = picture.width(), height = picture.height();
  std::vector<Spot> out;
  if (width <= 2 * outer + 1 || height <= 2 * outer + 1) return out;

  const double core_px = (2 * core + 1) * picture.cell_px();
  const double least = kMinGrey + kMinDeviations * noise_grey * std::sqrt(3.0) / core_px;
  // Keeps noise in a dark ring from looking like high contrast.
  const double floor_grey = 4 + noise_grey;
  std::vector<float> contrast(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  const auto at = [&](int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  };
  for (int y = outer; y + outer < height; ++y) {
    for (int x = outer; x + outer < width; ++x) {
      if (!picture.shows(x, y)) continue;
      const Color3 around = picture.ring_mean(x, y, inner, outer);
      const Color3 difference = picture.mean(x, y, core) - around;
      if (kind == SpotsOf::kBrighter && difference.sum() <= 0) continue;
      const double length = difference.norm();
      if (length < least) continue;
      contrast[at(x, y)] = static_cast<float>(length / (around.cwiseMax(0).norm() + floor_grey));
    }
  }
  const int apart = std::max(1, static_cast<int>(std::lround(0.8 * radius)));
  for (int y = outer; y + outer < height; ++y) {
    for (int x = outer; x + outer < width; ++x) {
      const float here = contrast[at(x, y)];
      if (here <= 0) continue;
      bool highest = true;
      for (int ny = y - apart; highest && ny <= y + apart; ++ny) {
        for (int nx = x - apart; nx <= x + apart; ++nx) {
          const float other = contrast[at(nx, ny)];
          // If values are equal, the first one counts as the highest.
          if (other > here || (other == here && (ny < y || (ny == y && nx < x)))) {
            highest = false;
            break;
          }
        }
      }
      if (!highest) continue;
      out.push_back({picture.pixel_of(x, y), picture.mean(x, y, core), picture.ring_mean(x, y, inner, outer),
                     static_cast<double>(here)});
    }
  }
  std::sort(out.begin(), out.end(), [](const Spot& a, const Spot& b) { return a.contrast > b.contrast; });
  if (out.size() > most) out.resize(most);
  return out;
}

}  // namespace sslv
