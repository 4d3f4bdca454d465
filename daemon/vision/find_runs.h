// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"
#include "vision/regions.h"

#include <tuple>

namespace sslv {

/// Run-length encodes the labelled image; clear cells make no runs.
class FindRuns {
 public:
  struct Params {
    int max_runs = 65'536;
    static constexpr auto fields() {
      return std::tuple{
          number("max_runs", &Params::max_runs, 1'000, 4'000'000, "",
                 "cap on runs: beyond it the rest of the picture is skipped, the frame flagged and counted")};
    }
  };
  void process(const Params& params, const LabelImage& labels, RunList& runs) noexcept;
};

}  // namespace sslv
