// SPDX-License-Identifier: Apache-2.0
#include "capture/simulator/simulator_carpet.h"

#include "capture/simulator/simulator_texture.h"

#include <cmath>
#include <numbers>

namespace sslv {
namespace {

enum Layer : std::uint64_t { kPile = 1, kDust = 2, kBlotches, kRed, kBlue, kWave, kStrip, kSeam, kPaths };

float share(const std::optional<double>& value) {
  return static_cast<float>(value.value());
}
float channel(const std::optional<int>& value) {
  return static_cast<float>(value.value());
}

}  // namespace

SimulatedCarpet::SimulatedCarpet(const HallOptions& hall, const FieldSize& field, const SimulatedLamps& lamps)
    : base_{channel(hall.carpet.red), channel(hall.carpet.green), channel(hall.carpet.blue)},
      blotches_{share(hall.carpet.blotches), hall.carpet.blotch_mm.value()},
      strips_{hall.carpet.strip_mm.value(), share(hall.carpet.strip_step), share(hall.carpet.seams), false},
      tint_(share(hall.carpet.tint)),
      weave_(share(hall.carpet.weave)),
      wear_(share(hall.carpet.wear)),
      shine_(share(hall.carpet.shine)),
      goal_mm_(field.field_length / 2.0 - 0.8 * field.penalty_area_depth, 0),
      lamp_mm_(lamps.places_mm().front()) {
  is_even_ = blotches_.contrast == 0 && tint_ == 0 && weave_ == 0 && strips_.width_mm == 0 && wear_ == 0 &&
             shine_ == 0;
  SimulatorRandom random(scatter(static_cast<std::uint64_t>(hall.seed)) + 2);
  strips_.along_x = random.bits() % 2 == 0;
  offset_mm_.x() = random.uniform(0, 1e6);
  offset_mm_.y() = random.uniform(0, 1e6);
}

float SimulatedCarpet::tone_at(const Eigen::Vector2d& p) {
  return 1 + 0.10F * lattice_noise(p.x(), p.y(), 14, kPile) + 0.12F * lattice_noise(p.x(), p.y(), 350, kDust);
}

/// Wear, 1 where it is strongest: in front of the goals, around the centre, and along winding paths.
float SimulatedCarpet::wear_at(const Eigen::Vector2d& field_mm, const Eigen::Vector2d& place_mm) const {
  const auto near = [](double distance_mm, double reach_mm) {
    const double t = distance_mm / reach_mm;
    return static_cast<float>(std::exp(-t * t));
  };
  const Eigen::Vector2d folded(std::abs(field_mm.x()), field_mm.y());
  const float places = 0.8F * near((folded - goal_mm_).norm(), 900) + 0.6F * near(field_mm.norm(), 800);
  const float path = 1 - std::abs(patches(place_mm.x(), place_mm.y(), 1500, kPaths));
  return std::min(1.0F, places + smooth_step(0.6F, 1, path));
}

/// Adds the slightly different brightness of the strips, and the seams between them.
void SimulatedCarpet::lay_strips(double across_mm, double along_mm, float& bright) const {
  constexpr double kSeamMm = 5;
  const double wave_mm = 4 * lattice_noise(along_mm, 0, 400, kWave, true);
  const double strip = std::floor(across_mm / strips_.width_mm),
               seam = std::round(across_mm / strips_.width_mm);
  bright += 2 * strips_.step * lattice_value(strip, 0, kStrip);
  const double off = (across_mm - seam * strips_.width_mm + wave_mm) / kSeamMm;
  // Most seams are dark gaps, some are bright ridges.
  const float sign = lattice_value(seam, 0, kSeam) > 0.2F ? 1.0F : -1.0F;
  bright += sign * strips_.seams * static_cast<float>(std::exp(-off * off));
}

Paint SimulatedCarpet::at(const Eigen::Vector2d& p, const Eigen::Vector3d& eye_mm) const {
  Paint color = base_.scaled(tone_at(p));
  if (is_even_) return color;
  const Eigen::Vector2d q = p + offset_mm_;
  float bright = 1;
  if (blotches_.contrast > 0)
    bright += blotches_.contrast * patches(q.x(), q.y(), blotches_.size_mm, kBlotches);
  const double across_mm = strips_.along_x ? p.y() : p.x(), along_mm = strips_.along_x ? p.x() : p.y();
  if (weave_ > 0) {
    constexpr double kAcrossMm = 23, kAlongMm = 31;
    const double across = std::sin(2 * std::numbers::pi * across_mm / kAcrossMm);
    const double along = std::sin(2 * std::numbers::pi * along_mm / kAlongMm);
    bright += weave_ * static_cast<float>(0.7 * across + 0.3 * along);
  }
  if (strips_.width_mm > 0) lay_strips(across_mm, along_mm, bright);
  color = color.scaled(std::max(bright, 0.2F));
  if (tint_ > 0) {
    color.r *= 1 + tint_ * patches(q.x(), q.y(), 0.8 * blotches_.size_mm, kRed);
    color.b *= 1 + 0.5F * tint_ * patches(q.x(), q.y(), 0.8 * blotches_.size_mm, kBlue);
  }
  if (wear_ > 0) {
    const float pale = 1.4F * color.luma();
    color = color.mixed({pale, pale, 0.95F * pale}, 0.5F * wear_ * wear_at(p, q));
  }
  if (shine_ > 0) {
    // The point where a mirror on the floor would show the lamp; pile spreads the reflection around it.
    const Eigen::Vector2d spot =
        (eye_mm.head<2>() * lamp_mm_.z() + lamp_mm_.head<2>() * eye_mm.z()) / (eye_mm.z() + lamp_mm_.z());
    const double off = (p - spot).norm() / (0.22 * eye_mm.z());
    constexpr Paint kSheen{46, 50, 44};
    const Paint sheen = kSheen.scaled(shine_ * bright / (1 + static_cast<float>(off * off)));
    color = {color.r + sheen.r, color.g + sheen.g, color.b + sheen.b};
  }
  return color;
}

}  // namespace sslv
