// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"
#include "vision/background.h"
#include "vision/lut.h"
#include "vision/mask.h"
#include "vision/regions.h"

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace sslv {

/// One picture, or a band of it, to be run-length encoded.
struct RunSearch {
  ImageView image;
  const Lut* lut;
  const Mask* mask;
  const Background* background;
  int row_begin, row_end;  // rows of cells
  std::size_t max_runs;    // the search ends with the row in which there are more
  Run* runs;               // room for max_runs and one more row of them
};

struct RunSearchResult {
  std::size_t runs = 0;
  BackgroundUse use;
};

/// Finds the runs of the labelled picture without making it, just as Threshold and FindRuns would. Written
/// once for vectors of any length (Google Highway) and chosen at the first call for the CPU it runs on.
RunSearchResult search_runs(const RunSearch& search) noexcept;

/// Writes one bit for each block of the table, `c` innermost in 64 bits: whether all of it has that label.
void find_uniform_blocks(const LutTable& table, Label label, std::uint64_t* uniform) noexcept;

/// Name of the instruction set search_runs() uses here: "AVX2", "NEON"...
std::string_view search_runs_target();

}  // namespace sslv
