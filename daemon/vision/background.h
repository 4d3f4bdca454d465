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

/// Boxes around the most frequent colours (the carpet, then the floor, the lines...). They label most of an
/// image without a table lookup.
struct Background {
  static constexpr std::size_t kMaxBoxes = 8;

  Label label = label::kClear;  // label of every colour in the boxes
  std::size_t boxes = 0;        // number of boxes in use
  std::array<ColorBox, kMaxBoxes> box;
  /// One bit for each block of the table in the images' colour space, ordered as LutTable::blocks: set if the
  /// whole block has `label`.
  alignas(64) std::array<std::uint64_t, std::size_t{1} << (2 * LutTable::kBlockBits)> blocks{};
  /// Whether the first box covers so much of the image that testing this box alone first saves time.
  bool first_alone = true;
};

/// Statistics of an image that was searched with the Background.
struct BackgroundUse {
  std::size_t blocks = 0, odd_blocks = 0;  // all blocks of 64 cells; blocks not wholly in the first box
};

/// Tracks the most frequent colours of a camera's images and keeps boxes around them. A box is as large as
/// possible while all colours in it have the same label. Samples a few pixels of each frame. Regrows the
/// boxes for a new table and from time to time, one box per frame, which takes about ten microseconds; so no
/// thread is needed, and the same images always give the same boxes. The boxes affect only the processing
/// time, never the results.
class BackgroundFollower {
 public:
  /// Call before each image. Allocates nothing.
  const Background& follow(const ImageView& image, const Lut& lut, const Mask& mask) noexcept;

  /// Call after each image.
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
  std::array<Bins, kSamples> samples_;  // ring buffer of the latest samples
  std::size_t sampled_ = 0;             // number of samples since the start
  /// Like Background::blocks, but always for the YUV table.
  std::array<std::uint64_t, kBins * kBins> yuv_blocks_;
  std::uint64_t lut_id_ = 0;  // 0: nothing learnt yet
  PixelFormat format_ = PixelFormat::kMono8;
  std::uint32_t random_ = 1;
  int age_ = 0, frames_between_ = 0;  // frames since the last growth; frames between growths
  int frames_without_first_ = 0;      // number of frames since the first box was last tested alone

  /// Boxes that are still being grown, one in each frame.
  struct Growth {
    bool goes_on = false, is_first = false;  // is_first: new table, so each box is used at once
    std::size_t boxes = 0;
    std::array<ColorBox, Background::kMaxBoxes> box;
    std::array<Bins, kSamples> left;  // samples that could be in a box and are not in any box yet
    std::size_t left_count = 0, all = 0;
  } growth_;
};

}  // namespace sslv
