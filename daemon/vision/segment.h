// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"
#include "base/workers.h"
#include "image/image.h"
#include "vision/background.h"
#include "vision/find_regions.h"
#include "vision/find_runs.h"
#include "vision/flood_cut.h"
#include "vision/lut.h"
#include "vision/mask.h"
#include "vision/regions.h"
#include "vision/segment_kernel.h"

#include <memory>
#include <tuple>
#include <vector>

namespace sslv {

/// Combines Threshold, FindRuns and FindRegions: makes the same runs and regions, bit for bit, without a
/// labelled image, at nearly the speed of reading the image once (docs/benchmarks.md).
class Segment {
 public:
  struct Params {
    FindRuns::Params runs;
    FindRegions::Params regions;
    int threads = 1;
    static constexpr auto fields() {
      return std::tuple{group("runs", &Params::runs, "as for find_runs"),
                        group("regions", &Params::regions, "as for find_regions"),
                        number("threads", &Params::threads, 1, 8, "",
                               "threads that share each image: more than one helps only a large camera with "
                               "processors to itself; several cameras have their own threads anyway")};
    }
  };
  void process(const Params& params, const Lut& lut, const Mask& mask, const Image& image, RunList& runs,
               RegionList& regions) noexcept;

 private:
  void share_out(int threads, const RunList& picture);

  /// Some rows of the image, and memory for their runs.
  struct Part {
    int row_begin = 0, row_end = 0;  // rows of cells
    std::unique_ptr<Run[]> runs;
    std::size_t room = 0;
    BackgroundUse use;
  };

  BackgroundFollower background_;
  FloodCut flood_cut_;
  std::vector<Part> parts_;
  std::vector<FloodCut::Band> found_;  // runs found in each part
  std::unique_ptr<Workers> workers_;
  int threads_ = 0;  // requested; the system may have given fewer
  FindRegions find_regions_;
};

}  // namespace sslv
