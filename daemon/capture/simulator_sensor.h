// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/simulator_options.h"
#include "capture/simulator_picture.h"
#include "capture/simulator_random.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace sslv {

/// Turns light into the bytes of a camera: lens blur, saturation, pixel format, noise. The bytes lie without
/// gaps between rows.
class SimulatorSensor {
 public:
  /// `stream` tells the noise of several cameras apart.
  SimulatorSensor(const SimulatorOptions& options, std::uint64_t stream);

  std::size_t picture_bytes() const;

  /// The pixels that the light inside `box` reaches, in whole units of the pixel format.
  PixelBox reached_from(const PixelBox& box) const;

  /// Writes the bytes of `box`, which must be in whole units of the pixel format, without noise.
  void develop(const LightPicture& light, const PixelBox& box, std::uint8_t* picture);

  /// Every sample gets noise of its own, new in each call.
  void add_noise(const std::uint8_t* clean, std::uint8_t* noisy);

 private:
  void blur_row(const LightPicture& light, const PixelBox& box, int y, float* out) const;
  void write_row(const float* rgb, const PixelBox& box, int y, std::uint8_t* picture) const;

  SimulatorOptions options_;
  std::vector<float> kernel_;  // one half of the blur from its middle; sums to 1 with the other half
  std::vector<float> rows_, line_;
  std::vector<std::int8_t> noise_;
  SimulatorRandom random_;
};

}  // namespace sslv
