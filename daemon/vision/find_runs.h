// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"
#include "vision/flood_cut.h"
#include "vision/regions.h"

#include <memory>
#include <tuple>

namespace sslv {

/// Run-length encodes the labelled image; makes no runs of clear cells and of labels that flood the image
/// (FloodCut).
class FindRuns {
 public:
  struct Params {
    int max_runs = 65'536;
    static constexpr auto fields() {
      return std::tuple{
          number("max_runs", &Params::max_runs, 1'000, 4'000'000, "",
                 "cap on runs: beyond it, labels are removed from the parts of the image with the most runs, "
                 "and the frame is flagged and counted")};
    }
  };
  void process(const Params& params, const LabelImage& labels, RunList& runs) noexcept;

 private:
  FloodCut flood_cut_;
  std::unique_ptr<Run[]> found_;
  std::size_t room_ = 0;
};

}  // namespace sslv
