// SPDX-License-Identifier: Apache-2.0
#include "floor.h"

#include "chance.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sslv::halls {
namespace {

/// The index of a tile, and the distance to its edge.
struct TilePlace {
  std::int32_t x, y;
  double from_edge_mm;
};
TilePlace tile_at(const Eigen::Vector2d& p, double tile_mm) {
  const double x = p.x() / tile_mm + 0.37, y = p.y() / tile_mm + 0.21;
  const double u = x - std::floor(x), v = y - std::floor(y);
  return {static_cast<std::int32_t>(std::floor(x)), static_cast<std::int32_t>(std::floor(y)),
          std::min({u, 1 - u, v, 1 - v}) * tile_mm};
}

}  // namespace

double Stripe::distance_mm(const Eigen::Vector2d& point_mm) const {
  const Eigen::Vector2d axis = b_mm - a_mm;
  const double half_length = axis.norm() / 2;
  const Eigen::Vector2d along = axis / (2 * half_length), p = point_mm - (a_mm + b_mm) / 2;
  const double u = std::abs(p.dot(along)) - half_length;
  const double v = std::abs(p.x() * along.y() - p.y() * along.x()) - half_width_mm;
  return std::max(u, v);
}

void paint_lines(const FieldSize& field, const Color& color, Floor& floor) {
  for (const FieldLine& line : field_lines(field)) {
    const Eigen::Vector2d a(line.x1, line.y1), b(line.x2, line.y2);
    // The two lines of a corner end at each other's outer edge.
    const Eigen::Vector2d end = (b - a).normalized() * (line.thickness / 2);
    floor.stripes.push_back({a - end, b + end, line.thickness / 2, color});
  }
  for (const FieldArc& arc : field_arcs(field)) {
    floor.rings.push_back({{arc.x, arc.y}, arc.radius, arc.thickness / 2, color});
  }
}

/// Low-frequency variation, per channel.
Color FloorPatch::carpet_tone(const Eigen::Vector2d& p) const {
  const Carpet& c = floor_.carpet;
  double tone = 1, red = 0, blue = 0;
  if (c.blotches > 0) {
    // Three octaves with standard deviations of 0.35 times their weights add up to about 0.42.
    const double bumps =
        smooth_noise(p.x() / c.blotch_mm, p.y() / c.blotch_mm, c.seed) +
        0.55 * smooth_noise(2.7 * p.x() / c.blotch_mm, 2.7 * p.y() / c.blotch_mm, c.seed + 1) +
        0.35 * smooth_noise(6.9 * p.x() / c.blotch_mm, 6.9 * p.y() / c.blotch_mm, c.seed + 2);
    tone += c.blotches * bumps / 0.42;
  }
  if (c.brush > 0) {
    // A patch has rather sharp edges.
    const double side = smooth_noise(p.x() / 700, p.y() / 900, c.seed + 3) +
                        0.3 * smooth_noise(p.x() / 90, p.y() / 90, c.seed + 4);
    tone += c.brush * std::clamp(4 * side, -1.0, 1.0);
  }
  if (c.tiles > 0) {
    const TilePlace tile = tile_at(p, c.tile_mm);
    tone += c.tiles * (((tile.x + tile.y) & 1) != 0 ? 1.0 : -1.0) +
            0.5 * c.tiles * cell_noise(tile.x, tile.y, c.seed + 5);
  }
  if (c.worn > 0) {
    // Most play is along the middle and around the penalty areas.
    const double along = std::exp(-std::pow(p.y() / (0.17 * c.field_width_mm), 2));
    const double goal =
        std::hypot(std::abs(p.x()) - 0.38 * c.field_length_mm, p.y() / 1.6) - 0.16 * c.field_width_mm;
    const double around = std::exp(-std::pow(goal / 220, 2));
    const double patchy = 0.65 + 0.5 * smooth_noise(p.x() / 210, p.y() / 120, c.seed + 6);
    const double share = c.worn * std::max(along * 0.7, around) * patchy;
    tone += share;
    red += 0.5 * share;
    blue += 0.4 * share;
  }
  if (c.hue > 0) {
    red += 2 * c.hue / 0.35 * smooth_noise(p.x() / 420, p.y() / 420, c.seed + 7);
    blue += c.hue / 0.35 * smooth_noise(p.x() / 380, p.y() / 380, c.seed + 8);
  }
  return {static_cast<float>(std::max(0.05, tone + red)), static_cast<float>(std::max(0.05, tone)),
          static_cast<float>(std::max(0.05, tone + blue))};
}

/// The carpet with its fine structure.
Color FloorPatch::carpet(const Eigen::Vector2d& p) const {
  const Carpet& c = floor_.carpet;
  double grain = 1;
  if (c.pile > 0) {
    grain += c.pile / 0.45 *
             (smooth_noise(p.x() / c.pile_mm, p.y() / (1.8 * c.pile_mm), c.seed + 10) +
              0.8 * smooth_noise(p.x() / (4.1 * c.pile_mm), p.y() / (4.1 * c.pile_mm), c.seed + 11));
  }
  if (c.weave > 0) {
    const double k = 2 * std::numbers::pi / c.weave_mm;
    grain += c.weave * std::sin(k * p.x()) * std::sin(k * (p.y() + 0.02 * p.x()));
  }
  if (c.seams > 0 && tile_at(p, c.tile_mm).from_edge_mm < c.seam_mm / 2) grain *= 1 - c.seams;
  return c.color * static_cast<float>(std::max(0.05, grain));
}

Color FloorPatch::ground(const Eigen::Vector2d& p) const {
  const Ground& g = floor_.ground;
  if (!g.planks) return g.color * (1 + 0.06F * smooth_noise(p.x() / 160, p.y() / 160, g.seed));
  const auto row = static_cast<std::int32_t>(std::floor(p.y() / 110));
  const double shift = 700.0 * cell_noise(row, 0, g.seed);
  const auto plank = static_cast<std::int32_t>(std::floor((p.x() + shift) / 1400));
  const double gap_mm = std::min(p.y() / 110 - row, 1 - (p.y() / 110 - row)) * 110;
  const float grain = 0.10F * smooth_noise(p.x() / 130, p.y() / 9, g.seed + 1);
  const float tone = 1 + 0.16F * cell_noise(plank, row, g.seed + 2) + grain;
  return g.color * (gap_mm < 1.5 ? 0.45F * tone : tone);
}

Color FloorPatch::at(const Eigen::Vector2d& p, const Color& tone) const {
  const Color* color = nullptr;
  for (const Ring* ring : rings_) {
    if (ring->distance_mm(p) < 0) color = &ring->color;
  }
  for (const Stripe* stripe : stripes_) {
    if (stripe->distance_mm(p) < 0) color = &stripe->color;
  }
  if (color != nullptr) {
    const bool is_gone =
        floor_.line_wear > 0 && smooth_noise(p.x() / 80, p.y() / 80, floor_.carpet.seed + 20) +
                                        0.8 * smooth_noise(p.x() / 9, p.y() / 9, floor_.carpet.seed + 21) >
                                    1.2 - 1.6 * floor_.line_wear;
    if (!is_gone) return *color;
  }
  return floor_.carpet.extent_mm.contains(p) ? Color(carpet(p) * tone) : ground(p);
}

void FloorPatch::look_around(const Eigen::Vector2d& middle_mm, double radius_mm) {
  around_.clear();
  for (const Stripe& stripe : floor_.stripes) {
    if (stripe.distance_mm(middle_mm) < radius_mm) around_.push_back(&stripe);
  }
}

Color FloorPatch::color(const Eigen::Vector2d& middle, const Eigen::Vector2d& right,
                        const Eigen::Vector2d& down, bool& in_the_way) {
  const double reach_mm = right.norm() + down.norm();
  stripes_.clear();
  rings_.clear();
  in_the_way = false;
  for (const Stripe* stripe : around_) {
    const double distance_mm = stripe->distance_mm(middle);
    if (distance_mm < reach_mm) stripes_.push_back(stripe);
    in_the_way = in_the_way || (stripe->in_the_way && distance_mm < reach_mm);
  }
  for (const Ring& ring : floor_.rings) {
    if (ring.distance_mm(middle) < reach_mm) rings_.push_back(&ring);
  }
  const auto& extent = floor_.carpet.extent_mm;
  const double carpet_edge_mm =
      std::min((middle - extent.min()).cwiseAbs().minCoeff(), (middle - extent.max()).cwiseAbs().minCoeff());
  const bool is_edge = !stripes_.empty() || !rings_.empty() || carpet_edge_mm < reach_mm;
  const int side = is_edge ? 6 : 2;
  const Color tone = carpet_tone(middle);
  Color sum = Color::Zero();
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      const double u = (i + 0.5) / side - 0.5, v = (j + 0.5) / side - 0.5;
      sum += at(middle + u * right + v * down, tone);
    }
  }
  sum /= static_cast<float>(side * side);
  for (const Shine& shine : floor_.shines) {
    const Eigen::Vector2d d = (middle - shine.at_mm).cwiseQuotient(shine.radii_mm);
    if (d.squaredNorm() < 9) sum += static_cast<float>(shine.strength * std::exp(-0.5 * d.squaredNorm()));
  }
  return sum;
}

}  // namespace sslv::halls
