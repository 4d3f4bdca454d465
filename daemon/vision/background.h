// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"
#include "vision/lut.h"
#include "vision/mask.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace sslv {

/// Levels [low, high] of U, V and Y.
struct ColorBox {
  std::array<std::uint8_t, 3> low{}, high{};
};

/// What lets most of an image pass without a look at the table: boxes around the commonest colours, the
/// carpet's first, then the floor's, the lines'...
struct Background {
  static constexpr std::size_t kMaxBoxes = 8;

  Label label = label::kClear;  // of every colour in the boxes
  std::size_t boxes = 0;        // how many of `box` count
  std::array<ColorBox, kMaxBoxes> box;
  /// One bit for each block of the table of the images' colours, ordered as LutTable::blocks: whether all
  /// of it has that label.
  alignas(64) std::array<std::uint64_t, std::size_t{1} << (2 * LutTable::kBlockBits)> blocks{};
  /// Whether so much of the image lies in the first box that it is worth while to try that one alone
  /// before.
  bool first_alone = true;
};

/// What an image was like for those who used its Background.
struct BackgroundUse {
  std::size_t blocks = 0, odd_blocks = 0;  // of 64 cells; odd: not wholly in the first box
};

/// Follows the commonest colours of a camera's images and keeps boxes around them that are as large as
/// their one label allows. It looks at a few pixels of a frame and grows the boxes again for another table
/// and now and then, one in each frame, in some ten microseconds; so it needs no thread, and the same
/// images always give the same boxes. What they are changes the time an image takes, never what is found
/// in it.
class BackgroundFollower {
 public:
  /// To be called before each image. Allocates nothing.
  const Background& follow(const ImageView& image, const Lut& lut, const Mask& mask) noexcept;

  /// To be told after each image.
  void note(const BackgroundUse& use) noexcept;

  /// Colours are counted in the table's blocks.
  static constexpr int kBins = 1 << LutTable::kBlockBits;
  using Bins = std::array<std::uint8_t, 3>;  // U, V, Y

 private:
  static constexpr std::size_t kSamples = 2048;
  void sample(const ImageView& image, const Mask& mask, int count);
  int random(int below);
  bool in_background(const Bins& bins) const;
  void take_table(const Lut& lut, PixelFormat format, Label label);
  void begin_growth();
  void grow_box();
  Label commonest_label(const LutTable& yuv) const;

  Background background_;
  std::array<Bins, kSamples> samples_;  // the latest ones, in a ring
  std::size_t sampled_ = 0;             // since the start
  /// As Background::blocks, of the table in YUV.
  std::array<std::uint64_t, kBins * kBins> yuv_blocks_;
  std::uint64_t lut_id_ = 0;  // 0: nothing learnt yet
  PixelFormat format_ = PixelFormat::kMono8;
  std::uint32_t random_ = 1;
  int age_ = 0, frames_between_ = 0;  // frames since the boxes were grown, and until they are again
  int frames_without_first_ = 0;      // for which the first box was not tried alone

  /// Boxes that are still being grown, one in each frame.
  struct Growth {
    bool goes_on = false, is_first = false;  // first: of a new table, so that each box is used at once
    std::size_t boxes = 0;
    std::array<ColorBox, Background::kMaxBoxes> box;
    std::array<Bins, kSamples> left;  // samples that could be in a box and are in none yet
    std::size_t left_count = 0, all = 0;
  } growth_;
};

}  // namespace sslv
