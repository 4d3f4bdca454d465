// SPDX-License-Identifier: Apache-2.0
#include "vision/find_regions.h"

#include <algorithm>
#include <utility>

namespace sslv {
namespace {

// A sort key holds label, area and place in 8, 28 and 28 bits: no image has more than 2^28 pixels.
constexpr int kPlaceBits = 28;
constexpr std::uint64_t kPlace = (std::uint64_t{1} << kPlaceBits) - 1, kMaxArea = kPlace;

}  // namespace

std::uint32_t FindRegions::root_of(std::uint32_t region) {
  while (growing_[region].parent != region) {
    growing_[region].parent = growing_[growing_[region].parent].parent;
    region = growing_[region].parent;
  }
  return region;
}

/// Joins two roots and returns their common root.
std::uint32_t FindRegions::join(std::uint32_t a, std::uint32_t b) {
  if (a == b) return a;
  if (b < a) std::swap(a, b);
  Growing& into = growing_[a];
  Growing& from = growing_[b];
  from.parent = a;
  into.cells += from.cells;
  into.x += from.x;
  into.y += from.y;
  into.left = std::min(into.left, from.left);
  into.top = std::min(into.top, from.top);
  into.right = std::max(into.right, from.right);
  into.bottom = std::max(into.bottom, from.bottom);
  return a;
}

/// Joins cells of neighbouring rows if their columns differ by at most `reach`.
void FindRegions::connect(const RunList& in, int reach) {
  const std::vector<Run>& runs = in.runs;
  const auto count = static_cast<std::uint32_t>(runs.size());
  constexpr std::uint32_t kNone = 0xFFFF'FFFF;
  // Reserved, so that no later image needs more memory.
  growing_.reserve(runs.capacity());
  region_of_.reserve(runs.capacity());
  keys_.reserve(runs.capacity());
  sorted_keys_.reserve(runs.capacity());
  growing_.clear();
  region_of_.resize(count);
  std::uint32_t above = 0;  // first run of the previous row that may touch the current one
  for (std::uint32_t i = 0; i < count; ++i) {
    const Run run = runs[i];
    while (above < i && (runs[above].y + 1 < run.y ||
                         (runs[above].y + 1 == run.y && runs[above].x_end + reach <= run.x_begin))) {
      ++above;
    }
    std::uint32_t region = kNone;
    for (std::uint32_t j = above; j < i && runs[j].y + 1 == run.y && runs[j].x_begin < run.x_end + reach;
         ++j) {
      if (runs[j].label != run.label) continue;
      const std::uint32_t other = root_of(region_of_[j]);
      region = region == kNone ? other : join(region, other);
    }

    const auto cells = static_cast<std::uint32_t>(run.x_end - run.x_begin);
    const std::uint64_t x = std::uint64_t{cells} * static_cast<std::uint32_t>(run.x_begin + run.x_end - 1);
    const std::uint64_t y = std::uint64_t{cells} * run.y;
    const auto right = static_cast<std::uint16_t>(run.x_end - 1);
    if (region == kNone) {
      region = static_cast<std::uint32_t>(growing_.size());
      growing_.push_back({region, i, x, y, cells, run.x_begin, run.y, right, run.y});
    } else {
      Growing& all = growing_[region];
      all.cells += cells;
      all.x += x;
      all.y += y;
      all.left = std::min(all.left, run.x_begin);
      all.right = std::max(all.right, right);
      all.bottom = run.y;
    }
    region_of_[i] = region;
  }
}

/// Sorts keys_. Uses a radix sort, beginning with the lowest byte, if there are too many keys for std::sort:
/// speckle makes thousands of regions. The keys arrive in the order of their indices, so the bits of the
/// indices need no sorting.
void FindRegions::sort_keys() {
  constexpr std::size_t kFew = 256, kDigits = 256;
  if (keys_.size() <= kFew) {
    std::sort(keys_.begin(), keys_.end());
    return;
  }
  sorted_keys_.resize(keys_.size());
  std::uint64_t varying = 0;
  for (const std::uint64_t key : keys_) varying |= key ^ keys_.front();
  for (int shift = kPlaceBits; shift < 64; shift += 8) {
    const auto digit = [shift](std::uint64_t key) { return key >> shift & (kDigits - 1); };
    if (digit(varying) == 0) continue;
    std::array<std::uint32_t, kDigits> place{};
    for (const std::uint64_t key : keys_) ++place[digit(key)];
    std::uint32_t begin = 0;
    for (std::uint32_t& one : place) begin += std::exchange(one, begin);
    for (const std::uint64_t key : keys_) sorted_keys_[place[digit(key)]++] = key;
    keys_.swap(sorted_keys_);
  }
}

void FindRegions::process(const Params& params, const RunList& in, RegionList& out) noexcept {
  connect(in, params.connectivity == Connectivity::kEight ? 1 : 0);

  const auto cell = static_cast<std::uint32_t>(in.cell_px);
  const auto max_regions = static_cast<std::size_t>(params.max_regions);
  keys_.clear();
  for (std::uint32_t i = 0; i < growing_.size(); ++i) {
    const Growing& one = growing_[i];
    if (one.parent != i || one.cells < static_cast<std::uint32_t>(params.min_cells)) continue;
    keys_.push_back((kMaxArea - std::min<std::uint64_t>(kMaxArea, one.cells * cell * cell)) << kPlaceBits |
                    i);
  }
  // Largest regions first; regions of equal area in reading order.
  out.capped = keys_.size() > max_regions;
  if (out.capped) {
    const auto last = keys_.begin() + params.max_regions;
    std::nth_element(keys_.begin(), last, keys_.end());
    keys_.erase(last, keys_.end());
    std::sort(keys_.begin(), keys_.end(),
              [](std::uint64_t a, std::uint64_t b) { return (a & kPlace) < (b & kPlace); });
  }
  for (std::uint64_t& key : keys_) {
    key |= std::uint64_t{in.runs[growing_[key & kPlace].first_run].label} << (2 * kPlaceBits);
  }
  sort_keys();

  out.regions.reserve(max_regions);
  out.regions.clear();
  out.begin.fill(0);
  const double offset = (in.cell_px - 1) * 0.5;  // a cell's centre in pixels
  const auto px = [cell](std::uint16_t c, std::uint32_t extra) {
    return static_cast<std::uint16_t>(c * cell + extra);
  };
  for (const std::uint64_t key : keys_) {
    const Growing& one = growing_[key & kPlace];
    const Label label = in.runs[one.first_run].label;
    out.regions.push_back({label, one.cells * cell * cell, px(one.left, 0), px(one.top, 0),
                           px(one.right, cell - 1), px(one.bottom, cell - 1),
                           static_cast<float>(0.5 * static_cast<double>(one.x) / one.cells * cell + offset),
                           static_cast<float>(static_cast<double>(one.y) / one.cells * cell + offset),
                           one.first_run});
    ++out.begin[label + 1U];
  }
  for (std::size_t l = 1; l < out.begin.size(); ++l) out.begin[l] += out.begin[l - 1];
}

}  // namespace sslv
