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

/// Removes the runs of labels that flood an image (have too many runs), so that the rest of the image is
/// searched in bounded time.
///
/// The image is divided into blocks of 64 x 64 cells. In each block a label may have 768 runs; a run that
/// extends over several blocks counts in each of them. Robots at the smallest distance that the rules allow
/// have about 100 runs; more runs are speckle, for example of green in dim light. Dots are still found among
/// this speckle. A label with more than 768 runs is cut from the block: its cells in the block count as
/// clear. All labels are cut from a block if at least four labels have speckle (more than 240 runs together,
/// counting at most 64 runs of each label) or if all labels together have more than 1024 runs: nothing can be
/// distinguished in such a block. If the remaining runs still exceed the cap of the whole image, the pairs of
/// a block and a label with the most runs are cut until the remaining runs fit.
///
/// The set of cut runs depends only on the image's labels, not on the order of processing. So a thread that
/// has found the runs of some rows can already query the blocks that will be cut in any case.
class FloodCut {
 public:
  static constexpr int kBlockCells = 64;
  static constexpr int kMaxOfLabel = 768, kMaxOfAll = 1024;  // runs in a block
  static constexpr int kMaxCounted = 64, kMaxNoise = 240;    // counted runs per label; counted runs in total

  /// Runs found in a band of rows, from the top down. A band begins and ends between blocks, or at the
  /// image's edge.
  struct Band {
    Run* runs;                // array of room(...) runs
    std::size_t count = 0;    // number of runs, in reading order
    std::size_t noted = 0;    // number of runs known to the FloodCut
    std::size_t strip = 0;    // index of the first run in the newest row of blocks
    bool is_counted = false;  // whether the runs in the newest row of blocks are counted per block
  };

  /// Maximum number of runs in `rows` rows of cells of an image, if note() is called after at most kNoteAfter
  /// new runs plus the runs of one row and `pending` more.
  static std::size_t room(int width, int rows, std::size_t pending);
  static constexpr std::size_t kNoteAfter = 1'024;

  /// Call before each image; sizes are in cells. Allocates only for a larger image than any before.
  void begin(int width, int height);

  /// Call after the last row of each row of blocks (`ends_strip`), and also after kNoteAfter runs. Drops runs
  /// that will be cut in any case. Different bands may be noted at the same time.
  void note(Band& band, bool ends_strip) noexcept;

  /// One bit for each block in a row of blocks, 64 blocks per word: set if all labels are cut from the block.
  /// One word after the last may be read.
  const std::uint64_t* cut_whole(int row_of_blocks) const {
    return whole_.data() + static_cast<std::size_t>(row_of_blocks * words_);
  }

  /// Writes the remaining runs of the bands and the cut blocks to `out`. note() must have been called for all
  /// runs.
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

  int blocks_across_ = 0, blocks_down_ = 0, words_ = 0;  // words_: words of whole_ per row of blocks
  // For each block, row by row:
  std::vector<std::uint32_t> cut_;  // a bit for each label
  struct Sums {
    std::uint16_t all, counted;  // runs
  };
  std::vector<Sums> sums_;                                           // for each block
  std::vector<std::array<std::uint16_t, label::kMaxCount>> counts_;  // numbers of runs, if counted
  std::vector<std::uint8_t> is_counted_;                             // for each row of blocks
  std::vector<std::uint64_t> whole_;
};

/// Human-readable text: "green floods the image between (0, 64) and (1279, 511) px".
std::string flood_text(const Flood& flood, std::string_view label_name);

}  // namespace sslv
