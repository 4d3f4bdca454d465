// SPDX-License-Identifier: Apache-2.0
#include "vision/find_runs.h"

namespace sslv {

void FindRuns::process(const Params& params, const LabelImage& labels, RunList& out) noexcept {
  out.width = labels.width;
  out.height = labels.height;
  out.cell_px = labels.cell_px;
  out.runs.reserve(static_cast<std::size_t>(params.max_runs));
  out.runs.clear();
  out.capped = false;
  const auto max_runs = static_cast<std::size_t>(params.max_runs);
  for (int y = 0; y < labels.height; ++y) {
    const Label* row = labels.row(y);
    for (int x = 0; x < labels.width;) {
      const Label label = row[x];
      const int begin = x;
      do {
        ++x;
      } while (x < labels.width && row[x] == label);
      if (label == label::kClear) continue;
      if (out.runs.size() == max_runs) {
        out.capped = true;
        return;
      }
      out.runs.push_back({static_cast<std::uint16_t>(y), static_cast<std::uint16_t>(begin),
                          static_cast<std::uint16_t>(x), label});
    }
  }
}

}  // namespace sslv
