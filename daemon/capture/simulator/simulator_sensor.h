// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/simulator/simulator_options.h"
#include "capture/simulator/simulator_picture.h"
#include "capture/simulator/simulator_random.h"

#include <array>
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

  /// Factors on red, green and blue from now on; 1 at first.
  void set_gains(const std::array<float, 3>& gains) { gains_ = gains; }

  /// Writes the bytes of `box`, which must be in whole units of the pixel format, without noise.
  void develop(const LightPicture& light, const PixelBox& box, std::uint8_t* picture);

  /// Every sample gets noise, new in each call. That of YUV pictures is what remains of noise in red, green
  /// and blue when they are mixed, so that it is weaker in the colours and correlated with the luma's.
  void add_noise(const std::uint8_t* clean, std::uint8_t* noisy);

 private:
  void blur_row(const LightPicture& light, const PixelBox& box, int y, float* out) const;
  void fill_noise(std::size_t entries);
  void write_row(const float* rgb, const PixelBox& box, int y, std::uint8_t* picture) const;

  SimulatorOptions options_;
  std::array<float, 3> gains_{1, 1, 1};
  std::vector<float> kernel_;  // one half of the blur from its middle; sums to 1 with the other half
  std::vector<float> rows_, line_;
  std::vector<std::int8_t> noise_;  // rows take it from a random place on
  std::size_t noise_unit_;          // which is a multiple of this
  SimulatorRandom random_;
};

}  // namespace sslv
