// SPDX-License-Identifier: Apache-2.0
#include "vision/flood_cut.h"

#include <algorithm>
#include <array>
#include <bit>

namespace sslv {
namespace {

constexpr std::uint32_t kAllLabels = 0xFFFF'FFFF;
static_assert(label::kMaxCount == 32);
constexpr int kWordBits = 64;

int blocks_in(int cells) {
  return (cells + FloodCut::kBlockCells - 1) / FloodCut::kBlockCells;
}

}  // namespace

std::size_t FloodCut::room(int width, int rows, std::size_t pending) {
  // Maximum number of runs that note() leaves in a row of blocks: runs that are not cut, and runs of cut
  // labels that extend into another block, at most one for each row of cells at the border of two blocks.
  const int strip = blocks_in(width) * (kMaxOfAll + kBlockCells);
  return static_cast<std::size_t>(blocks_in(rows) * strip + width) + kNoteAfter + pending;
}

void FloodCut::begin(int width, int height) {
  blocks_across_ = blocks_in(width);
  blocks_down_ = blocks_in(height);
  words_ = (blocks_across_ + kWordBits - 1) / kWordBits;
  const auto blocks = static_cast<std::size_t>(blocks_across_ * blocks_down_);
  cut_.assign(blocks, 0);
  sums_.resize(blocks);
  counts_.resize(blocks);
  is_counted_.assign(static_cast<std::size_t>(blocks_down_), 0);
  whole_.assign(static_cast<std::size_t>(words_ * blocks_down_ + 1), 0);
}

/// Counts a run. Returns whether it causes a label to be cut from a block.
bool FloodCut::count(const Run& run) {
  bool cuts = false;
  const std::size_t first = block_of(run);
  const std::size_t last =
      first + static_cast<std::size_t>((run.x_end - 1) / kBlockCells - run.x_begin / kBlockCells);
  const std::size_t label = run.label % label::kMaxCount;
  for (std::size_t block = first; block <= last; ++block) {
    if (is_cut(block, run.label)) continue;
    Sums& sums = sums_[block];
    ++sums.all;
    if (++counts_[block][label] <= kMaxCounted) ++sums.counted;
    if (counts_[block][label] > kMaxOfLabel) {
      cut_[block] |= 1U << label;
      cuts = true;
    }
    if (sums.all > kMaxOfAll || sums.counted > kMaxNoise) {
      cut_[block] = kAllLabels;
      const std::size_t across = block % static_cast<std::size_t>(blocks_across_);
      const std::size_t down = block / static_cast<std::size_t>(blocks_across_);
      whole_[down * static_cast<std::size_t>(words_) + across / kWordBits] |= std::uint64_t{1}
                                                                              << across % kWordBits;
      cuts = true;
    }
  }
  return cuts;
}

/// Drops cut runs, except runs that extend into another block. Returns the end of the remaining runs.
std::size_t FloodCut::drop_cut(Run* runs, std::size_t begin, std::size_t end) const {
  Run* left = std::remove_if(runs + begin, runs + end, [this](const Run& run) {
    return is_cut(block_of(run), run.label) && is_in_one_block(run);
  });
  return static_cast<std::size_t>(left - runs);
}

void FloodCut::note(Band& band, bool ends_strip) noexcept {
  // Usually there are so few runs that no label floods any block; then the runs are not counted.
  if (!band.is_counted && band.count - band.strip > static_cast<std::size_t>(kMaxNoise)) {
    const auto row = static_cast<std::size_t>(band.runs[band.strip].y / kBlockCells);
    const auto across = static_cast<std::size_t>(blocks_across_);
    std::fill_n(sums_.begin() + static_cast<std::ptrdiff_t>(row * across), across, Sums{});
    for (std::size_t block = row * across; block < (row + 1) * across; ++block) counts_[block].fill(0);
    is_counted_[row] = 1;
    band.is_counted = true;
    band.noted = band.strip;
  }
  if (band.is_counted) {
    bool cuts = false;
    for (std::size_t i = band.noted; i < band.count; ++i) cuts |= count(band.runs[i]);
    band.count = drop_cut(band.runs, cuts ? band.strip : band.noted, band.count);
  }
  band.noted = band.count;
  if (!ends_strip) return;
  band.strip = band.count;
  band.is_counted = false;
}

/// Appends the runs that are not cut. Returns false if there are more than max_runs.
bool FloodCut::append(const Band& band, std::size_t max_runs, std::vector<Run>& out) const {
  for (std::size_t i = 0; i < band.count; ++i) {
    const Run run = band.runs[i];
    Run part = run;
    std::size_t block = block_of(run);
    // A run is not split between neighbouring blocks that keep its label.
    for (int x = run.x_begin; x < run.x_end; ++block) {
      const int end = std::min<int>(run.x_end, (x / kBlockCells + 1) * kBlockCells);
      if (is_cut(block, run.label)) {
        if (part.x_begin < x) {
          if (out.size() == max_runs) return false;
          part.x_end = static_cast<std::uint16_t>(x);
          out.push_back(part);
        }
        part.x_begin = static_cast<std::uint16_t>(end);
      }
      x = end;
    }
    if (part.x_begin == run.x_end) continue;
    if (out.size() == max_runs) return false;
    part.x_end = run.x_end;
    out.push_back(part);
  }
  return true;
}

void FloodCut::cut_fullest(std::span<const Band> bands, std::size_t max_runs) {
  const auto across = static_cast<std::size_t>(blocks_across_);
  for (std::size_t row = 0; row < is_counted_.size(); ++row) {
    if (is_counted_[row] != 0) continue;
    for (std::size_t block = row * across; block < (row + 1) * across; ++block) {
      counts_[block].fill(0);
      sums_[block] = {};
    }
  }
  for (const Band& band : bands) {
    for (std::size_t i = 0; i < band.count; ++i) {
      if (is_counted_[band.runs[i].y / kBlockCells] == 0) count(band.runs[i]);
    }
  }
  std::fill(is_counted_.begin(), is_counted_.end(), std::uint8_t{1});

  // runs[n]: total number of runs in those pairs of a block and a label that have n runs each.
  std::array<std::size_t, kMaxOfLabel + 1> runs{};
  const auto for_each = [&](auto what) {
    for (std::size_t block = 0; block < counts_.size(); ++block) {
      for (std::size_t label = 0; label < label::kMaxCount; ++label) {
        if (!is_cut(block, static_cast<Label>(label))) what(block, label, counts_[block][label]);
      }
    }
  };
  for_each([&](std::size_t, std::size_t, std::uint16_t count) { runs[count] += count; });
  std::size_t most = 0, left = max_runs;
  while (most < static_cast<std::size_t>(kMaxOfLabel) && runs[most + 1] <= left) left -= runs[++most];
  for_each([&](std::size_t block, std::size_t label, std::uint16_t count) {
    if (count > most) cut_[block] |= 1U << label;
  });
}

void FloodCut::finish(std::span<const Band> bands, std::size_t max_runs, RunList& out) {
  out.runs.reserve(max_runs);
  out.runs.clear();
  out.flood = {};
  out.cut.reserve(cut_.size());
  out.cut.clear();
  std::size_t all = 0;
  for (const Band& band : bands) all += band.count;
  if (all <= max_runs && std::all_of(cut_.begin(), cut_.end(), [](std::uint32_t cut) { return cut == 0; })) {
    for (const Band& band : bands) out.runs.insert(out.runs.end(), band.runs, band.runs + band.count);
    return;
  }
  const auto append_all = [&] {
    return std::all_of(bands.begin(), bands.end(),
                       [&](const Band& band) { return append(band, max_runs, out.runs); });
  };
  if (!append_all()) {
    cut_fullest(bands, max_runs);
    out.runs.clear();
    append_all();
  }
  out.flood = describe(out.cell_px);
  out.cut = cut_;
}

Flood FloodCut::describe(int cell_px) const {
  std::array<int, label::kMaxCount> blocks{};
  int whole = 0;
  for (const std::uint32_t cut : cut_) {
    if (cut == kAllLabels) {
      ++whole;
      continue;
    }
    for (std::uint32_t left = cut; left != 0; left &= left - 1)
      ++blocks[static_cast<std::size_t>(std::countr_zero(left))];
  }
  const auto most = std::max_element(blocks.begin(), blocks.end());
  Flood flood;
  if (*most == 0 && whole == 0) return flood;
  flood.label = *most > whole ? static_cast<Label>(most - blocks.begin()) : label::kClear;
  flood.cell_px = static_cast<std::uint8_t>(cell_px);
  const std::uint32_t wanted = flood.label == label::kClear ? kAllLabels : 1U << flood.label;
  const auto place = [](int block) { return static_cast<std::uint8_t>(std::min(block, 255)); };
  for (int y = 0; y < blocks_down_; ++y) {
    for (int x = 0; x < blocks_across_; ++x) {
      if ((cut_[static_cast<std::size_t>(y * blocks_across_ + x)] & wanted) != wanted) continue;
      const bool is_first = flood.blocks++ == 0;
      flood.left = is_first ? place(x) : std::min(flood.left, place(x));
      flood.right = std::max(flood.right, place(x));
      flood.top = is_first ? place(y) : flood.top;
      flood.bottom = place(y);
    }
  }
  return flood;
}

std::string flood_text(const Flood& flood, std::string_view label_name) {
  const int block_px = FloodCut::kBlockCells * flood.cell_px;
  std::string text(flood.label == label::kClear ? "every colour" : label_name);
  text += " floods the image between (" + std::to_string(flood.left * block_px) + ", " +
          std::to_string(flood.top * block_px) + ") and (" +
          std::to_string((flood.right + 1) * block_px - 1) + ", " +
          std::to_string((flood.bottom + 1) * block_px - 1) + ") px";
  return text;
}

}  // namespace sslv
