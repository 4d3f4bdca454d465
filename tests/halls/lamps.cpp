// SPDX-License-Identifier: Apache-2.0
#include "lamps.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace sslv::halls {
namespace {

/// Light of a flat lamp that hangs parallel to the floor.
double light_of(const Lamp& lamp, const Eigen::Vector2d& floor_mm) {
  const double z2 = lamp.at_mm.z() * lamp.at_mm.z();
  const double distance2 = (lamp.at_mm.head<2>() - floor_mm).squaredNorm() + z2;
  return lamp.strength * z2 * z2 / (distance2 * distance2);
}

}  // namespace

LightMap::LightMap(const Lighting& lighting, const CameraModel& camera, const Eigen::AlignedBox2d& area_mm)
    : lighting_(lighting),
      columns_(camera.calibration().pixel_image_width / kStep + 2),
      rows_(camera.calibration().pixel_image_height / kStep + 2),
      width_(camera.calibration().pixel_image_width),
      height_(camera.calibration().pixel_image_height),
      of_lamp_(lighting.lamps.size() * static_cast<std::size_t>(columns_ * rows_)),
      nodes_(static_cast<std::size_t>(columns_ * rows_)) {
  const std::size_t count = nodes_.size();
  std::vector<double> sums(count);
  std::vector<Eigen::Vector2d> places(count);
  double mean = 0, places_within = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector2d pixel(static_cast<double>(i % static_cast<std::size_t>(columns_)) * kStep,
                                static_cast<double>(i / static_cast<std::size_t>(columns_)) * kStep);
    const auto place = camera.unproject(pixel, 0);
    if (!place) throw std::runtime_error("the camera does not see the floor everywhere");
    places[i] = *place;
    for (const Lamp& lamp : lighting.lamps) sums[i] += light_of(lamp, *place);
    if (!area_mm.contains(*place)) continue;
    mean += sums[i];
    ++places_within;
  }
  mean /= places_within;
  double furthest = 1e-9;
  for (std::size_t i = 0; i < count; ++i) {
    if (area_mm.contains(places[i])) furthest = std::max(furthest, std::abs(sums[i] / mean - 1));
  }
  const double corner2 = std::pow(width_ / 2.0, 2) + std::pow(height_ / 2.0, 2);
  for (std::size_t i = 0; i < count; ++i) {
    const double x = static_cast<double>(i % static_cast<std::size_t>(columns_)) * kStep - width_ / 2.0;
    const double y = static_cast<double>(i / static_cast<std::size_t>(columns_)) * kStep - height_ / 2.0;
    const double even = std::max(0.2, 1 + (sums[i] / mean - 1) * lighting.uneven / furthest);
    const double seen = even * (1 - lighting.vignette * (x * x + y * y) / corner2);
    for (std::size_t lamp = 0; lamp < lighting.lamps.size(); ++lamp) {
      const double share = light_of(lighting.lamps[lamp], places[i]) / sums[i];
      of_lamp_[lamp * count + i] = lighting.lamps[lamp].tint * static_cast<float>(seen * share);
    }
  }
  shine(std::vector<double>(lighting.lamps.size(), 1.0));
}

void LightMap::shine(std::span<const double> factors) {
  std::fill(nodes_.begin(), nodes_.end(), Color::Zero());
  for (std::size_t lamp = 0; lamp < lighting_.lamps.size(); ++lamp) {
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      nodes_[i] += of_lamp_[lamp * nodes_.size() + i] * static_cast<float>(factors[lamp]);
    }
  }
}

Color LightMap::at(double pixel_x, double pixel_y) const {
  const double x = std::clamp(pixel_x / kStep, 0.0, columns_ - 1.001);
  const double y = std::clamp(pixel_y / kStep, 0.0, rows_ - 1.001);
  const auto u = static_cast<float>(x - std::floor(x)), v = static_cast<float>(y - std::floor(y));
  const Color* node = &nodes_[static_cast<std::size_t>(static_cast<int>(y) * columns_ + static_cast<int>(x))];
  return (node[0] * (1 - u) + node[1] * u) * (1 - v) +
         (node[columns_] * (1 - u) + node[columns_ + 1] * u) * v;
}

void LightMap::light_row(int y, std::span<Color> row) const {
  Color left = at(0, y), right = left;
  for (int x = 0; x < static_cast<int>(row.size()); ++x) {
    const int within = x % kStep;
    if (within == 0) {
      left = at(x, y);
      right = at(x + kStep, y);
    }
    row[static_cast<std::size_t>(x)] *= left + (right - left) * (static_cast<float>(within) / kStep);
  }
}

LightFrom LightMap::from(const Eigen::Vector2d& place_mm) const {
  std::vector<const Lamp*> brightest;
  for (const Lamp& lamp : lighting_.lamps) brightest.push_back(&lamp);
  std::sort(brightest.begin(), brightest.end(),
            [&](const Lamp* a, const Lamp* b) { return light_of(*a, place_mm) > light_of(*b, place_mm); });
  LightFrom out;
  double sum = 0;
  for (std::size_t i = 0; i < out.directions.size(); ++i) {
    const Lamp& lamp = *brightest[std::min(i, brightest.size() - 1)];
    const Eigen::Vector3d to_lamp = lamp.at_mm - Eigen::Vector3d(place_mm.x(), place_mm.y(), 0);
    out.directions[i] = to_lamp.normalized().cast<float>();
    out.shares[i] = static_cast<float>(light_of(lamp, place_mm));
    sum += light_of(lamp, place_mm);
  }
  for (float& share : out.shares) share /= static_cast<float>(sum);
  return out;
}

}  // namespace sslv::halls
