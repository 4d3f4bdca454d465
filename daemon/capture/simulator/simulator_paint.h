// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sslv {

/// The light that a surface reflects under white light of brightness 1, in 8-bit grey levels; or a light's
/// factors on red, green and blue.
struct Paint {
  float r, g, b;

  Paint scaled(float factor) const { return {r * factor, g * factor, b * factor}; }
  /// Interpolates from this paint (`share` 0) to `other` (`share` 1).
  Paint mixed(const Paint& other, float share) const {
    return {r + (other.r - r) * share, g + (other.g - g) * share, b + (other.b - b) * share};
  }
  float luma() const { return 0.299F * r + 0.587F * g + 0.114F * b; }
};

}  // namespace sslv
