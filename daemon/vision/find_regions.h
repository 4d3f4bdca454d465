// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"
#include "vision/regions.h"

#include <array>
#include <cstdint>
#include <tuple>
#include <vector>

namespace sslv {

enum class Connectivity { kFour, kEight };

/// Joins runs of one label that touch into regions (union-find over rows, Bruce et al. 2000), with area,
/// centroid and box, sorted by label and falling area.
class FindRegions {
 public:
  struct Params {
    int min_cells = 2;
    int max_regions = 20'000;
    Connectivity connectivity = Connectivity::kFour;
    static constexpr auto fields() {
      return std::tuple{
          number("min_cells", &Params::min_cells, 1, 1'000, "cells",
                 "regions of fewer cells are noise and dropped at once; a speed limit, not a size filter "
                 "(those are in mm)"),
          number("max_regions", &Params::max_regions, 100, 1'000'000, "",
                 "cap on regions: beyond it, the smallest are dropped and the frame is flagged and counted"),
          choice("connectivity", &Params::connectivity,
                 std::array{Choice<Connectivity>{"4", Connectivity::kFour},
                            Choice<Connectivity>{"8", Connectivity::kEight}},
                 "whether cells that touch only at a corner belong together"),
      };
    }
  };
  void process(const Params& params, const RunList& runs, RegionList& regions) noexcept;

 private:
  /// A growing region, coordinates in cells. If two regions turn out to be connected, the earlier region
  /// absorbs the later region.
  struct Growing {
    std::uint32_t parent;  // itself, or the region that absorbed it
    std::uint32_t first_run;
    std::uint64_t x, y;  // sums over the cells; x: doubled, so that it is an integer
    std::uint32_t cells;
    std::uint16_t left, top, right, bottom;  // box, inclusive
  };
  void connect(const RunList& runs, int reach);
  void sort_keys();
  std::uint32_t root_of(std::uint32_t region);
  std::uint32_t join(std::uint32_t a, std::uint32_t b);

  std::vector<Growing> growing_;          // ordered by their first runs
  std::vector<std::uint32_t> region_of_;  // for each run: its region, or a region absorbed by it
  // Sort keys, each with the region's index in growing_:
  std::vector<std::uint64_t> keys_, sorted_keys_;
};

}  // namespace sslv
