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

/// Converts light into a camera's bytes: lens blur, saturation, pixel format, noise, bit depth, hot pixels.
/// Rows have no padding.
class SimulatorSensor {
 public:
  /// `stream` seeds the noise, so that cameras differ; its lower 32 bits identify the camera.
  SimulatorSensor(const SimulatorOptions& options, std::uint64_t stream);

  /// With more than 8 bits, a second plane of this size follows the image (ImageView::to_low_bits).
  std::size_t plane_bytes() const;
  std::size_t picture_bytes() const { return (is_deep() ? 2 : 1) * plane_bytes(); }

  /// The pixels that the light inside `box` affects, in whole units of the pixel format.
  DrawnBox reached_from(const DrawnBox& box) const;

  /// Sets the factors on red, green and blue; initially 1. set_row_gain() sets the factor on a row; initially
  /// 1.
  void set_gains(const std::array<float, 3>& gains) { gains_ = gains; }
  void set_row_gain(int y, float gain) { row_gains_[static_cast<std::size_t>(y)] = gain; }

  /// Writes the bytes of `box`, which must be in whole units of the pixel format, without noise.
  void develop(const LightPicture& light, const DrawnBox& box, std::uint8_t* picture);

  /// The light of a whole image after the lens blur, for develop_blurred(): red, green, blue per pixel.
  std::vector<float> blurred(const LightPicture& light);
  /// Like develop() of the whole image, but faster.
  void develop_blurred(const std::vector<float>& blurred, std::uint8_t* picture);

  /// Adds noise to every sample, new noise in each call. In YUV images, the noise of red, green and blue is
  /// mixed like the colours, so the noise of U and V is weaker, and correlated with the noise of Y. Also adds
  /// hot pixels.
  void add_noise(const std::uint8_t* clean, std::uint8_t* noisy);

 private:
  /// A sample of a hot pixel. `excess` may be negative for U and V.
  struct HotSample {
    std::size_t at;
    int excess;
  };

  bool is_deep() const { return options_.bits > 8; }
  template <class Use>
  void blur(const LightPicture& light, const DrawnBox& box, const Use& use);
  void blur_row(const LightPicture& light, const DrawnBox& box, int y, float* out) const;
  void expose_row(float* rgb, const DrawnBox& box, int y, std::uint8_t* picture) const;
  void fill_noise(std::size_t entries);
  void fill_block_noise();
  void place_hot_pixels(std::uint64_t stream);
  void add_deep_noise(const std::uint8_t* clean, std::uint8_t* noisy);
  void add_block_noise(std::uint8_t* picture);
  void write_row(const float* rgb, const DrawnBox& box, int y, std::uint8_t* picture) const;

  SimulatorOptions options_;  // with `hall` resolved
  std::array<float, 3> gains_{1, 1, 1};
  std::vector<float> row_gains_;
  std::vector<float> kernel_;  // half of the blur kernel, from its centre; the whole kernel sums to 1
  std::vector<float> rows_, line_;
  std::vector<std::int8_t> noise_;        // each row starts at a random offset
  std::vector<std::int16_t> deep_noise_;  // replaces noise_ above 8 bits; in 1/256 of a level
  std::size_t noise_unit_;                // offsets into noise_ are multiples of this
  SimulatorRandom random_;
  std::vector<std::int8_t> block_noise_;  // kBlockPx rows; each row of blocks starts at a random block pair
  std::vector<HotSample> hot_samples_;
};

}  // namespace sslv
