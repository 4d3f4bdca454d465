// SPDX-License-Identifier: Apache-2.0
#include "vision/rectangle_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Dense>

namespace sslv {
namespace {

constexpr int kAngles = 4, kSteps = 8;
constexpr double kMinVariance = 0.5, kMinHalfMm = 3, kMaxStepMm = 5, kMaxTurnRad = 0.25;

/// A blurred step: 0 far before an edge, 0.5 at the edge, 1 far behind the edge. The blur's sigma is a third
/// of `half`.
struct Step {
  float is, slope;
  Step(float from_edge, float half) {
    const float z = std::clamp(from_edge / half, -1.0F, 1.0F), z2 = z * z, w = 1 - z2;
    is = 0.5F + z * (35.0F / 32) * (1 + z2 * (-1 + z2 * (0.6F - z2 / 7)));
    slope = 35.0F / 32 * w * w * w / half;
  }
};

using Moves = Eigen::Matrix<double, 5, 1>;  // x, y (along the sides), half length, half width, angle

/// Residuals of a rectangle, and the normal equations for a step to a better rectangle.
struct Sums {
  double cost = 0;  // sum over planes of count times log of the residual variance
  Eigen::Matrix<double, 5, 5> normal = Eigen::Matrix<double, 5, 5>::Zero();
  Moves gradient = Moves::Zero();
};

Sums sum_up(const Rectangle& r, std::span<RectangleSamples* const> groups) {
  Sums out;
  const auto c = static_cast<float>(std::cos(r.angle_rad)), s = static_cast<float>(std::sin(r.angle_rad));
  const auto a = static_cast<float>(r.half_length), b = static_cast<float>(r.half_width);
  const auto x0 = static_cast<float>(r.x), y0 = static_cast<float>(r.y);
  for (RectangleSamples* const group : groups) {
    if (group->count == 0) continue;
    const auto& blur = group->blur_mm2;
    const auto half_of = [&](double nx, double ny) {
      return static_cast<float>(
          3 * std::sqrt(nx * nx * blur[0][0] + 2 * nx * ny * blur[0][1] + ny * ny * blur[1][1] + 1e-6));
    };
    const float half_p = half_of(c, s), half_q = half_of(-s, c);
    Eigen::Matrix<float, 7, 7> products = Eigen::Matrix<float, 7, 7>::Zero();  // moves, cover, one
    Eigen::Matrix<float, 7, 3> with = Eigen::Matrix<float, 7, 3>::Zero();
    Eigen::Vector3f square = Eigen::Vector3f::Zero();
    for (std::size_t i = 0; i < group->count; ++i) {
      const float x = group->x[i] - x0, y = group->y[i] - y0, p = c * x + s * y, q = c * y - s * x;
      const Step p1(a - p, half_p), p2(a + p, half_p), q1(b - q, half_q), q2(b + q, half_q);
      const float in_p = p1.is * p2.is, in_q = q1.is * q2.is;
      const float towards_p = (p1.slope * p2.is - p1.is * p2.slope) * in_q;
      const float towards_q = (q1.slope * q2.is - q1.is * q2.slope) * in_p;
      Eigen::Matrix<float, 7, 1> row;
      row << towards_p, towards_q, (p1.slope * p2.is + p1.is * p2.slope) * in_q,
          (q1.slope * q2.is + q1.is * q2.slope) * in_p, towards_q * p - towards_p * q, in_p * in_q, 1;
      products.noalias() += row * row.transpose();
      for (std::size_t k = 0; k < group->planes; ++k) {
        const float value = group->value[k][i];
        with.col(static_cast<Eigen::Index>(k)) += value * row;
        square[static_cast<Eigen::Index>(k)] += value * value;
      }
    }
    const Eigen::Matrix2d gram = products.bottomRightCorner<2, 2>().cast<double>();
    const double determinant = gram.determinant();
    const Eigen::Matrix<double, 5, 2> cross = products.topRightCorner<5, 2>().cast<double>();
    const bool is_seen = determinant > 1e-3;
    const Eigen::Matrix2d inverse = is_seen ? Eigen::Matrix2d(gram.inverse()) : Eigen::Matrix2d::Zero();
    for (std::size_t k = 0; k < group->planes; ++k) {
      const auto plane = with.col(static_cast<Eigen::Index>(k)).cast<double>();
      const Eigen::Vector2d seen = plane.tail<2>();
      Eigen::Vector2d weights = inverse * seen;
      if (!is_seen) weights = {0, seen[1] / static_cast<double>(group->count)};
      const auto n = static_cast<double>(group->count);
      const double left2 =
          std::max(0.0, static_cast<double>(square[static_cast<Eigen::Index>(k)]) - weights.dot(seen));
      group->left2[k] = left2;
      const double variance = left2 / n + kMinVariance;
      out.cost += n * std::log(variance);
      out.normal += weights[0] * weights[0] / variance *
                    (products.topLeftCorner<5, 5>().cast<double>() - cross * inverse * cross.transpose());
      out.gradient += weights[0] / variance * (plane.head<5>() - cross * weights);
    }
  }
  return out;
}

Rectangle moved(const Rectangle& r, const Moves& step) {
  const double c = std::cos(r.angle_rad), s = std::sin(r.angle_rad);
  return {r.x + c * step[0] - s * step[1], r.y + s * step[0] + c * step[1],
          std::max(kMinHalfMm, r.half_length + step[2]), std::max(kMinHalfMm, r.half_width + step[3]),
          r.angle_rad + step[4]};
}

}  // namespace

Rectangle fit_rectangle(const Rectangle& start, std::span<RectangleSamples* const> groups) noexcept {
  Rectangle best = start;
  Sums sums;
  for (int i = 0; i < kAngles; ++i) {
    Rectangle turned = start;
    turned.angle_rad += i * std::numbers::pi / 2 / kAngles;
    const Sums other = sum_up(turned, groups);
    if (i > 0 && !(other.cost < sums.cost)) continue;
    best = turned;
    sums = other;
  }
  double damping = 0.01;
  for (int step = 0; step < kSteps; ++step) {
    Eigen::Matrix<double, 5, 5> normal = sums.normal;
    for (Eigen::Index k = 0; k < 5; ++k) normal(k, k) += damping * normal(k, k) + 1e-6;
    Moves by = normal.ldlt().solve(sums.gradient);
    for (Eigen::Index k = 0; k < 4; ++k) by[k] = std::clamp(by[k], -kMaxStepMm, kMaxStepMm);
    by[4] = std::clamp(by[4], -kMaxTurnRad, kMaxTurnRad);
    if (!by.allFinite()) break;
    const Rectangle next = moved(best, by);
    const Sums other = sum_up(next, groups);
    if (!(other.cost < sums.cost)) {
      damping = std::max(0.1, 10 * damping);
      continue;
    }
    const bool done = sums.cost - other.cost < 0.05;
    best = next;
    sums = other;
    damping *= 0.2;
    if (done) break;
  }
  sum_up(best, groups);
  return best;
}

}  // namespace sslv
