// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace sslv {

/// SplitMix64's output function (Steele, Lea, Flood 2014): scatters neighbouring numbers over all 64 bits.
constexpr std::uint64_t scatter(std::uint64_t z) {
  z += 0x9e3779b97f4a7c15U;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
  return z ^ (z >> 31);
}

/// Random numbers that depend only on the seed. (The distributions of <random> differ between compilers and
/// libraries.)
class SimulatorRandom {
 public:
  explicit SimulatorRandom(std::uint64_t seed) : state_(seed) {}

  std::uint64_t bits() {
    state_ += 0x9e3779b97f4a7c15U;
    return scatter(state_);
  }
  /// Uniform in [low, high).
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(bits() >> 11) * 0x1p-53;
  }
  double angle() { return uniform(-std::numbers::pi, std::numbers::pi); }
  /// Mean 0, standard deviation 1 (Box-Muller).
  double normal() {
    const double u = 1 - uniform(0, 1);
    return std::sqrt(-2 * std::log(u)) * std::cos(angle());
  }

 private:
  std::uint64_t state_;
};

}  // namespace sslv
