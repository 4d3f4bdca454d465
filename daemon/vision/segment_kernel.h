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
  FloodCut* flood_cut;     // is told of the runs, and tells where none are wanted any more
  FloodCut::Band* found;   // with room for kMaxPendingRuns besides
};

/// Runs of many rows are found at once: up to so many besides those of one row.
inline constexpr std::size_t kMaxPendingRuns = 12 * 1'024;

/// Finds the runs of the labelled image without making it, just as Threshold and FindRuns would. Written
/// once for vectors of any length (Google Highway) and chosen at the first call for the CPU it runs on.
/// Blocks from which all labels are cut (FloodCut) are passed over once that is known.
BackgroundUse search_runs(const RunSearch& search) noexcept;

/// Writes one bit for each block of the table, `c` innermost in 64 bits: whether all of it has that label.
void find_uniform_blocks(const LutTable& table, Label label, std::uint64_t* uniform) noexcept;

/// Name of the instruction set search_runs() uses here: "AVX2", "NEON"...
std::string_view search_runs_target();

}  // namespace sslv
