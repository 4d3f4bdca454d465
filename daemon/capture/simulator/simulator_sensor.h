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

/// Turns light into the bytes of a camera: lens blur, saturation, pixel format, noise, bits, hot pixels. The
/// bytes lie without gaps between rows.
class SimulatorSensor {
 public:
  /// `stream` tells the noise of several cameras apart; its lower half says which camera this is.
  SimulatorSensor(const SimulatorOptions& options, std::uint64_t stream);

  /// With more than 8 bits a second plane as large follows the image (ImageView::to_low_bits).
  std::size_t plane_bytes() const;
  std::size_t picture_bytes() const { return (is_deep() ? 2 : 1) * plane_bytes(); }

  /// The pixels that the light inside `box` reaches, in whole units of the pixel format.
  DrawnBox reached_from(const DrawnBox& box) const;

  /// Factors on red, green and blue from now on, and on each row; 1 at first.
  void set_gains(const std::array<float, 3>& gains) { gains_ = gains; }
  void set_row_gain(int y, float gain) { row_gains_[static_cast<std::size_t>(y)] = gain; }

  /// Writes the bytes of `box`, which must be in whole units of the pixel format, without noise.
  void develop(const LightPicture& light, const DrawnBox& box, std::uint8_t* picture);

  /// All of an image's light after the lens, for develop_blurred(): red, green, blue of each pixel.
  std::vector<float> blurred(const LightPicture& light);
  /// As develop() of the whole image, for less work.
  void develop_blurred(const std::vector<float>& blurred, std::uint8_t* picture);

  /// Every sample gets noise, new in each call. That of YUV images is what remains of noise in red, green
  /// and blue when they are mixed, so that it is weaker in the colours and correlated with the luma's. Hot
  /// pixels come on top.
  void add_noise(const std::uint8_t* clean, std::uint8_t* noisy);

 private:
  /// A sample that is too bright, or too dark: U and V of a pixel that is.
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

  SimulatorOptions options_;  // with a hall that is resolved
  std::array<float, 3> gains_{1, 1, 1};
  std::vector<float> row_gains_;
  std::vector<float> kernel_;  // one half of the blur from its middle; sums to 1 with the other half
  std::vector<float> rows_, line_;
  std::vector<std::int8_t> noise_;        // rows take it from a random place on
  std::vector<std::int16_t> deep_noise_;  // with more than 8 bits instead; in 256ths of a level
  std::size_t noise_unit_;                // which is a multiple of this
  SimulatorRandom random_;
  std::vector<std::int8_t> block_noise_;  // kBlockPx rows; a row of blocks takes it from a random block on
  std::vector<HotSample> hot_samples_;
};

}  // namespace sslv
