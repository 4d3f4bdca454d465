// SPDX-License-Identifier: Apache-2.0
#include "capture/simulator/simulator_lamps.h"

#include "capture/simulator/simulator_random.h"

#include <algorithm>
#include <cmath>

namespace sslv {

SimulatedLamps::SimulatedLamps(const HallOptions& hall, const FieldSize& field)
    : uneven_(static_cast<float>(hall.lamps.uneven.value())),
      cast_(static_cast<float>(hall.lamps.cast.value())),
      flicker_low_(hall.lamps.flicker_low.value()),
      flicker_high_(hall.lamps.flicker_high.value()) {
  SimulatorRandom random(scatter(static_cast<std::uint64_t>(hall.seed)) + 3);
  const double half_x = field.field_length / 2.0 + field.boundary_width_goal_line;
  const double half_y = field.field_width / 2.0 + field.boundary_width;
  // Two rows under the ceiling; one lamp is old and weak.
  constexpr double kApartMm = 3500;
  const int columns = std::max(2, static_cast<int>(std::lround(2 * half_x / kApartMm)));
  for (int row = 0; row < 2; ++row) {
    for (int column = 0; column < columns; ++column) {
      const double x = ((column + 0.5) / columns * 2 - 1) * half_x, y = (row - 0.5) * half_y;
      places_mm_.emplace_back(x + random.uniform(-400, 400), y + random.uniform(-400, 400),
                              random.uniform(4500, 6500));
      strengths_.push_back(random.uniform(0.7, 1.2));
    }
  }
  strengths_[random.bits() % strengths_.size()] *= 0.4;

  constexpr int kSteps = 40;
  double sum = 0, least = 1e300, most = 0;
  const auto each_place = [&](auto look) {
    for (int i = 0; i <= kSteps; ++i) {
      for (int j = 0; j <= kSteps; ++j) {
        look(sum_at({(2.0 * i / kSteps - 1) * half_x, (2.0 * j / kSteps - 1) * half_y}));
      }
    }
  };
  each_place([&](double light) {
    sum += light;
    least = std::min(least, light);
    most = std::max(most, light);
  });
  mean_ = sum / ((kSteps + 1) * (kSteps + 1));
  scale_ = uneven_ / std::max(most / mean_ - 1, 1 - least / mean_);

  const double angle = random.angle();
  warm_side_ = Eigen::Vector2d(std::cos(angle) / half_x, std::sin(angle) / half_y);
}

double SimulatedLamps::sum_at(const Eigen::Vector2d& field_mm) const {
  double sum = 0;
  for (std::size_t i = 0; i < places_mm_.size(); ++i) {
    const double z = places_mm_[i].z(), d2 = (places_mm_[i].head<2>() - field_mm).squaredNorm() + z * z;
    // Lambert's cosine law at the flat lamp and at the flat floor.
    sum += strengths_[i] * z * z / (d2 * d2);
  }
  return sum;
}

Paint SimulatedLamps::at(const Eigen::Vector2d& field_mm) const {
  const auto light = static_cast<float>(std::clamp(1 + scale_ * (sum_at(field_mm) / mean_ - 1), 0.1, 2.0));
  const float warm = cast_ * static_cast<float>(std::clamp(field_mm.dot(warm_side_), -1.0, 1.0));
  return {light * (1 + warm), light, light * (1 - warm)};
}

double SimulatedLamps::flicker(int scene_seed, std::int64_t picture) const {
  SimulatorRandom random(
      scatter(scatter(static_cast<std::uint64_t>(scene_seed)) + static_cast<std::uint64_t>(picture)) + 1);
  return std::exp(random.uniform(std::log(flicker_low_), std::log(flicker_high_)));
}

}  // namespace sslv
