// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"
#include "vision/background.h"
#include "vision/flood_cut.h"
#include "vision/lut.h"
#include "vision/mask.h"
#include "vision/regions.h"

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace sslv {

/// One image, or a band of it, to be run-length encoded.
struct RunSearch {
  ImageView image;
  const Lut* lut;
  const Mask* mask;
  const Background* background;
  int row_begin, row_end;  // rows of cells
  FloodCut* flood_cut;     // receives the runs, and has the blocks to skip
  FloodCut::Band* found;   // with additional room for kMaxPendingRuns
};

/// Runs of several rows are found together: at most this many, in addition to the runs of one row.
inline constexpr std::size_t kMaxPendingRuns = 12 * 1'024;

/// Finds the same runs as Threshold and FindRuns without making the labelled image. Written once for vectors
/// of any length (Google Highway); the first call selects the version for the CPU. Skips blocks in which all
/// labels are known to be cut (FloodCut).
BackgroundUse search_runs(const RunSearch& search) noexcept;

/// Writes one bit for each block of the table, `c` innermost in 64 bits: set if the whole block has `label`.
void find_uniform_blocks(const LutTable& table, Label label, std::uint64_t* uniform) noexcept;

/// Name of the instruction set search_runs() uses here: "AVX2", "NEON"...
std::string_view search_runs_target();

}  // namespace sslv
