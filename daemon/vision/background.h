// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"
#include "vision/lut.h"
#include "vision/mask.h"

#include <array>
#include <cstdint>

namespace sslv {

/// Channels [low, high] of colours, as LutTable names them: a, b, c.
struct ColorBox {
  std::array<std::uint8_t, 3> low{}, high{};
};

/// What lets most of a picture pass without a look at the table: the colours of the carpet, and of the next
/// commonest thing, such as the floor around it.
struct Background {
  Label label = label::kClear;  // of every colour in the boxes
  int boxes = 0;                // how many of `box` count
  std::array<ColorBox, 2> box;
  /// Chromas (LutTable::chroma) that may have another label than that: bit b % 8 of byte [b / 8][a]. Grey
  /// pictures have (Y / 8, 0) in their place.
  alignas(16) std::uint8_t odd_chroma[4][32] = {};
};

/// Follows the commonest colours of a camera's pictures and keeps boxes around them that are as large as
/// their one label allows. It looks at a few pixels of a frame and grows the boxes anew now and then, and at
/// once for another table, in some ten microseconds; so it needs no thread, and the same pictures always give
/// the same boxes. What they are changes the time a picture takes, never what is found in it.
class BackgroundFollower {
 public:
  /// To be called before each picture. Allocates nothing.
  const Background& follow(const ImageView& image, const Lut& lut, const Mask& mask) noexcept;

  /// To be told after each picture: how many of its blocks were not wholly in the first box, and how many of
  /// those were wholly in the second.
  void note(std::size_t blocks, std::size_t odd_blocks, std::size_t in_second) noexcept;

  /// Values are counted in steps of the table's blocks.
  static constexpr int kBins = 1 << LutTable::kBlockBits;
  using Counts = std::array<std::array<std::uint32_t, kBins>, 3>;
  using Bins = std::array<int, 3>;

 private:
  /// A common colour and what the samples around it are like.
  struct Mode {
    Counts all{}, near{};  // near: of samples close to the median in every channel
    Bins median{};

    void add(const Bins& bins);
    void find_median();
    void fade();
  };
  void sample(const ImageView& image, const Mask& mask, int count);
  void grow(const LutTable& table, PixelFormat format);
  void find_boxes(const LutTable& table);

  Background background_;
  std::array<Mode, 2> modes_;  // of all samples; of those outside the first box
  std::uint64_t lut_id_ = 0;   // 0: nothing learnt yet
  PixelFormat format_ = PixelFormat::kMono8;
  std::uint32_t random_ = 1;
  int age_ = 0;                    // frames since the boxes were grown
  double odd_share_at_first_ = 0;  // of the blocks, right after that
  bool fits_badly_ = false;        // compared with that: the light may have changed
};

}  // namespace sslv
