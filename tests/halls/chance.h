// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <string_view>

namespace sslv::halls {

/// Sebastiano Vigna's splitmix64: every bit of the result depends on every bit of `x`.
constexpr std::uint64_t mixed(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15ULL;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31);
}

/// Random numbers that depend only on a seed, a purpose and a number, so that a frame does not depend on the
/// frames drawn before it.
class Chance {
 public:
  Chance(std::uint64_t seed, std::string_view purpose, std::uint64_t number = 0) : state_(mixed(seed)) {
    for (const char c : purpose) state_ = mixed(state_ ^ static_cast<unsigned char>(c));
    state_ = mixed(state_ ^ mixed(number));
  }

  std::uint64_t bits() { return mixed(state_ += 0x9E3779B97F4A7C15ULL); }
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(bits() >> 11) * 0x1p-53;
  }
  double log_uniform(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }
  double normal() {
    const double radius = std::sqrt(-2 * std::log(uniform(1e-12, 1)));
    return radius * std::cos(uniform(0, 2 * std::numbers::pi));
  }
  /// Both ends included.
  int whole(int low, int high) {
    return low + static_cast<int>(bits() % static_cast<std::uint64_t>(high - low + 1));
  }
  bool happens(double probability) { return uniform(0, 1) < probability; }
  double sign() { return happens(0.5) ? 1 : -1; }
  template <class T, std::size_t N>
  const T& one_of(const T (&choices)[N]) {
    return choices[bits() % N];
  }

 private:
  std::uint64_t state_;
};

/// Noise in -1..1 that is constant per cell.
inline float cell_noise(std::int32_t x, std::int32_t y, std::uint32_t seed) {
  std::uint32_t h = static_cast<std::uint32_t>(x) * 0x8DA6B343U ^
                    static_cast<std::uint32_t>(y) * 0xD8163841U ^ seed * 0xCB1AB31FU;
  h = (h ^ (h >> 15)) * 0x2C1B3C6DU;
  h = (h ^ (h >> 12)) * 0x297A2D39U;
  h ^= h >> 15;
  return static_cast<float>(h) * 0x1p-31F - 1;
}

/// Smooth noise within -1..1, standard deviation about 0.35, one bump per unit.
inline float smooth_noise(double x, double y, std::uint32_t seed) {
  const double fx = std::floor(x), fy = std::floor(y);
  const auto ix = static_cast<std::int32_t>(fx), iy = static_cast<std::int32_t>(fy);
  auto u = static_cast<float>(x - fx), v = static_cast<float>(y - fy);
  u = u * u * (3 - 2 * u);
  v = v * v * (3 - 2 * v);
  const float a = cell_noise(ix, iy, seed), b = cell_noise(ix + 1, iy, seed);
  const float c = cell_noise(ix, iy + 1, seed), d = cell_noise(ix + 1, iy + 1, seed);
  return (a + (b - a) * u) * (1 - v) + (c + (d - c) * u) * v;
}

}  // namespace sslv::halls
