// SPDX-License-Identifier: Apache-2.0
#include "vision/find_runs.h"

namespace sslv {

void FindRuns::process(const Params& params, const LabelImage& labels, RunList& out) noexcept {
  out.width = labels.width;
  out.height = labels.height;
  out.cell_px = labels.cell_px;
  flood_cut_.begin(labels.width, labels.height);
  const std::size_t room = FloodCut::room(labels.width, labels.height, 0);
  if (room_ < room) {
    found_ = std::make_unique_for_overwrite<Run[]>(room);
    room_ = room;
  }
  FloodCut::Band band{found_.get()};
  for (int y = 0; y < labels.height; ++y) {
    const Label* row = labels.row(y);
    for (int x = 0; x < labels.width;) {
      const Label label = row[x];
      const int begin = x;
      do {
        ++x;
      } while (x < labels.width && row[x] == label);
      if (label == label::kClear) continue;
      band.runs[band.count++] = {static_cast<std::uint16_t>(y), static_cast<std::uint16_t>(begin),
                                 static_cast<std::uint16_t>(x), label};
    }
    const bool ends_strip = (y + 1) % FloodCut::kBlockCells == 0 || y + 1 == labels.height;
    if (ends_strip || band.count - band.noted >= FloodCut::kNoteAfter) flood_cut_.note(band, ends_strip);
  }
  flood_cut_.finish(std::span(&band, 1), static_cast<std::size_t>(params.max_runs), out);
}

}  // namespace sslv
