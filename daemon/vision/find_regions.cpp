// SPDX-License-Identifier: Apache-2.0
#include "vision/find_regions.h"

#include <algorithm>

namespace sslv {

std::uint32_t FindRegions::root_of(std::uint32_t run) {
  while (sums_[run].parent != run) {
    sums_[run].parent = sums_[sums_[run].parent].parent;
    run = sums_[run].parent;
  }
  return run;
}

void FindRegions::join(std::uint32_t a, std::uint32_t b) {
  a = root_of(a);
  b = root_of(b);
  if (a == b) return;
  // The earlier run stays root: it is the region's first in reading order.
  if (b < a) std::swap(a, b);
  Sums& into = sums_[a];
  const Sums& from = sums_[b];
  sums_[b].parent = a;
  into.cells += from.cells;
  into.x += from.x;
  into.y += from.y;
  into.left = std::min(into.left, from.left);
  into.top = std::min(into.top, from.top);
  into.right = std::max(into.right, from.right);
  into.bottom = std::max(into.bottom, from.bottom);
}

void FindRegions::process(const Params& params, const RunList& in, RegionList& out) noexcept {
  const std::vector<Run>& runs = in.runs;
  const auto count = static_cast<std::uint32_t>(runs.size());
  sums_.resize(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const Run& run = runs[i];
    const auto length = static_cast<std::uint32_t>(run.x_end - run.x_begin);
    sums_[i] = {i,
                length,
                static_cast<std::uint64_t>(run.x_begin + run.x_end - 1) * length,
                static_cast<std::uint64_t>(run.y) * length,
                run.x_begin,
                run.y,
                static_cast<std::uint16_t>(run.x_end - 1),
                run.y};
  }

  // `above` walks the runs of the previous row beside those of the present one.
  const int reach = params.connectivity == Connectivity::kEight ? 1 : 0;
  std::uint32_t above = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Run& run = runs[i];
    while (above < i && (runs[above].y + 1 < run.y ||
                         (runs[above].y + 1 == run.y && runs[above].x_end + reach <= run.x_begin))) {
      ++above;
    }
    for (std::uint32_t j = above; j < i && runs[j].y + 1 == run.y && runs[j].x_begin < run.x_end + reach;
         ++j) {
      if (runs[j].label == run.label) join(i, j);
    }
  }

  unsorted_.clear();
  out.begin.fill(0);
  const int cell = in.cell_px;
  const double offset = (cell - 1) * 0.5;  // a cell's centre in pixels
  for (std::uint32_t i = 0; i < count; ++i) {
    const Sums& sum = sums_[i];
    if (sum.parent != i || sum.cells < static_cast<std::uint32_t>(params.min_cells)) continue;
    const auto px = [cell](std::uint16_t c, int extra) {
      return static_cast<std::uint16_t>(c * cell + extra);
    };
    unsorted_.push_back({runs[i].label, sum.cells * static_cast<std::uint32_t>(cell * cell), px(sum.left, 0),
                         px(sum.top, 0), px(sum.right, cell - 1), px(sum.bottom, cell - 1),
                         static_cast<float>(0.5 * static_cast<double>(sum.x) / sum.cells * cell + offset),
                         static_cast<float>(static_cast<double>(sum.y) / sum.cells * cell + offset), i});
  }

  out.capped = unsorted_.size() > static_cast<std::size_t>(params.max_regions);
  if (out.capped) {
    const auto last = unsorted_.begin() + params.max_regions;
    std::nth_element(unsorted_.begin(), last, unsorted_.end(), [](const Region& a, const Region& b) {
      return a.area_px != b.area_px ? a.area_px > b.area_px : a.first_run < b.first_run;
    });
    unsorted_.erase(last, unsorted_.end());
  }

  std::sort(unsorted_.begin(), unsorted_.end(), [](const Region& a, const Region& b) {
    if (a.label != b.label) return a.label < b.label;
    return a.area_px != b.area_px ? a.area_px > b.area_px : a.first_run < b.first_run;
  });
  out.regions.assign(unsorted_.begin(), unsorted_.end());
  for (const Region& region : out.regions) ++out.begin[region.label + 1U];
  for (std::size_t l = 1; l < out.begin.size(); ++l) out.begin[l] += out.begin[l - 1];
}

}  // namespace sslv
