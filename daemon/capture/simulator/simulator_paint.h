// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sslv {

/// What a surface reflects under white light at brightness 1, in 8-bit grey levels; or factors of a light.
struct Paint {
  float r, g, b;

  Paint scaled(float factor) const { return {r * factor, g * factor, b * factor}; }
  /// Towards another: all of it for 1.
  Paint mixed(const Paint& other, float share) const {
    return {r + (other.r - r) * share, g + (other.g - g) * share, b + (other.b - b) * share};
  }
  float luma() const { return 0.299F * r + 0.587F * g + 0.114F * b; }
};

}  // namespace sslv
