// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/regions.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sslv {

/// Takes from an image's runs what floods, so that the rest of the image is found, in bounded time.
///
/// The image is looked at in blocks of 64 x 64 cells. In each of them a label may have 768 runs, as far as
/// they lie in the block. Robots that stand as densely as the rules allow have some 100; what is beyond that
/// is speckle, as of green in dim light, among which dots are still found. A label with more is cut from that
/// block: its cells there count as clear. Where four labels or more have speckle (more than 240 runs
/// together, of each no more than 64 counted), or all together have more than 1024 runs, nothing can be told
/// from anything: all labels are cut. When what is left is still more than the cap of the whole image, the
/// fullest pairs of block and label are cut until the rest fits.
///
/// Which runs are cut depends only on the image's labels, not on the order of work: a thread that has
/// found the runs of some rows may ask already then what will be cut in any case.
class FloodCut {
 public:
  static constexpr int kBlockCells = 64;
  static constexpr int kMaxOfLabel = 768, kMaxOfAll = 1024;  // runs in a block
  static constexpr int kMaxCounted = 64, kMaxNoise = 240;    // of a label; of all as far as counted

  /// Runs that were found in a band of rows, from the top down. A band begins and ends between blocks, or at
  /// the image's edge.
  struct Band {
    Run* runs;                // room(...) of them
    std::size_t count = 0;    // of runs, in reading order
    std::size_t noted = 0;    // of them known to the FloodCut
    std::size_t strip = 0;    // where those of the newest row of blocks begin
    bool is_counted = false;  // the runs of that row, block by block
  };

  /// Runs that `rows` of an image can have, when note() is called after no more than kNoteAfter of them, and
  /// those of one row and `pending` more.
  static std::size_t room(int width, int rows, std::size_t pending);
  static constexpr std::size_t kNoteAfter = 1'024;

  /// Before each image; sizes are in cells. Allocates for a larger image than any before.
  void begin(int width, int height);

  /// To be called after the last row of each row of blocks (`ends_strip`), and besides after kNoteAfter runs.
  /// Drops runs that will be cut in any case. Different bands may be noted at the same time.
  void note(Band& band, bool ends_strip) noexcept;

  /// One bit for each block of a row of blocks: whether all labels are cut there. 64 blocks a word; there is
  /// one more word to read.
  const std::uint64_t* cut_whole(int row_of_blocks) const {
    return whole_.data() + static_cast<std::size_t>(row_of_blocks * words_);
  }

  /// Writes what is left of the bands' runs, all of which have been noted, and what was cut.
  void finish(std::span<const Band> bands, std::size_t max_runs, RunList& out);

 private:
  std::size_t block_of(const Run& run) const {
    return static_cast<std::size_t>(run.y / kBlockCells * blocks_across_ + run.x_begin / kBlockCells);
  }
  bool count(const Run& run);
  bool is_in_one_block(const Run& run) const {
    return run.x_begin / kBlockCells == (run.x_end - 1) / kBlockCells;
  }
  bool is_cut(std::size_t block, Label label) const {
    return (cut_[block] >> (label % label::kMaxCount) & 1U) != 0;
  }
  std::size_t drop_cut(Run* runs, std::size_t begin, std::size_t end) const;
  bool append(const Band& band, std::size_t max_runs, std::vector<Run>& out) const;
  void cut_fullest(std::span<const Band> bands, std::size_t max_runs);
  Flood describe(int cell_px) const;

  int blocks_across_ = 0, blocks_down_ = 0, words_ = 0;  // words_: of whole_, for a row of blocks
  // By block, row by row:
  std::vector<std::uint32_t> cut_;  // a bit for each label
  struct Sums {
    std::uint16_t all, counted;  // runs
  };
  std::vector<Sums> sums_;                                           // of each block
  std::vector<std::array<std::uint16_t, label::kMaxCount>> counts_;  // of runs, where they were counted
  std::vector<std::uint8_t> is_counted_;                             // by row of blocks
  std::vector<std::uint64_t> whole_;
};

/// "green floods the image between (0, 64) and (1279, 511) px", for people.
std::string flood_text(const Flood& flood, std::string_view label_name);

}  // namespace sslv
