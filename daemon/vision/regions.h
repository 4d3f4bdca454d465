// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/label.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace sslv {

/// One label per cell. A cell is a pixel, or for Bayer images a 2x2 quad of them.
struct LabelImage {
  int width = 0, height = 0;  // cells
  int cell_px = 1;            // side of a cell: 1, or 2 for Bayer
  std::vector<Label> labels;  // width * height, row by row

  /// First label of row `y`.
  const Label* row(int y) const {
    return labels.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
  }
  /// First label of row `y`.
  Label* row(int y) { return labels.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width); }

  /// Encodes a copy for another process (pipeline/part_codec.h); leaves out labels beyond the image's cells.
  template <class Writer>
  void encode(Writer& to) const {
    const std::size_t cells =
        width > 0 && height > 0 ? static_cast<std::size_t>(width) * static_cast<std::size_t>(height) : 0;
    const std::size_t count = cells < labels.size() ? cells : labels.size();
    to.bytes(&width, sizeof width);
    to.bytes(&height, sizeof height);
    to.bytes(&cell_px, sizeof cell_px);
    to.count(count);
    to.bytes(labels.data(), count);
  }
  template <class Reader>
  bool decode(Reader& from) {
    std::size_t count = 0;
    if (!from.bytes(&width, sizeof width) || !from.bytes(&height, sizeof height) ||
        !from.bytes(&cell_px, sizeof cell_px) || !from.count(count, 1))
      return false;
    labels.resize(count);
    return from.bytes(labels.data(), count);
  }
};

/// Neighbouring cells of a row with the same label, which is never "clear".
struct Run {
  std::uint16_t y, x_begin, x_end;  // cells; x_end is one past the last
  Label label;
};

/// The part of an image from which a label was cut because it had too many runs (FloodCut); the frame is
/// flagged. Positions are in blocks of FloodCut::kBlockCells cells. Small enough for a lock-free atomic.
struct alignas(8) Flood {
  std::uint16_t blocks = 0;     // number of blocks with cut labels; 0: no flood
  Label label = label::kClear;  // the label cut from most blocks; "clear": all labels
  std::uint8_t cell_px = 1;
  std::uint8_t left = 0, top = 0, right = 0, bottom = 0;  // box around the blocks, inclusive
};

/// The runs of an image.
struct RunList {
  int width = 0, height = 0;  // cells of the label image
  int cell_px = 1;
  std::vector<Run> runs;  // in reading order
  Flood flood;            // the part of the image with cut labels
  /// For each block (FloodCut), row by row: a bit for each label that was cut from it. Empty: no flood.
  std::vector<std::uint32_t> cut;
};

/// Connected cells of one label.
struct Region {
  Label label;
  std::uint32_t area_px;                   // pixels of the image, also for Bayer
  std::uint16_t left, top, right, bottom;  // box in pixels, inclusive
  float x_px, y_px;                        // centroid, in pixels of the image
  std::uint32_t first_run;                 // index into RunList::runs
};

/// The regions of an image.
struct RegionList {
  std::vector<Region> regions;  // by label, then by falling area, then in reading order
  bool capped = false;          // there were more regions than allowed; the frame is flagged

  /// All regions of a label, largest first.
  std::span<const Region> of(Label label) const {
    return std::span(regions).subspan(begin[label], begin[label + 1U] - begin[label]);
  }
  std::array<std::uint32_t, 257> begin{};  // begin[l] .. begin[l + 1] are the regions of label l
};

}  // namespace sslv
