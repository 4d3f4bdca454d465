// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <Eigen/Core>

namespace sslv::halls {

/// Red, green and blue in linear light; 1 saturates the sensor. An object's colour is what the camera
/// receives from it in average light.
using Color = Eigen::Array3f;

/// A camera's conversion of light to 8 bits. Cameras differ: some apply a "gamma".
enum class Transfer : std::uint8_t { kLinear, kSrgb };

/// Both within 0..1; kSrgb is IEC 61966-2-1.
inline float encoded(float light, Transfer transfer) {
  if (transfer == Transfer::kLinear) return light;
  return light <= 0.0031308F ? 12.92F * light : 1.055F * std::pow(light, 1 / 2.4F) - 0.055F;
}
inline float decoded(float code, Transfer transfer) {
  if (transfer == Transfer::kLinear) return code;
  return code <= 0.04045F ? code / 12.92F : std::pow((code + 0.055F) / 1.055F, 2.4F);
}

/// The colour that appears as these 8-bit values, which may exceed 255, in average light.
struct Seen {
  double r, g, b;
  Color in(Transfer transfer) const {
    return {decoded(static_cast<float>(r / 255), transfer), decoded(static_cast<float>(g / 255), transfer),
            decoded(static_cast<float>(b / 255), transfer)};
  }
};

/// Hue in degrees, 0 red, 120 green; saturation 0..1; value 0..255.
inline Seen seen_of_hsv(double hue_deg, double saturation, double value) {
  const auto channel = [&](double n) {
    const double k = std::fmod(n + hue_deg / 60, 6.0);
    return value * (1 - saturation * std::clamp(std::min(k, 4 - k), 0.0, 1.0));
  };
  return {channel(5), channel(3), channel(1)};
}

}  // namespace sslv::halls
