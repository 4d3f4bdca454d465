// SPDX-License-Identifier: Apache-2.0
#include "vision/segment.h"

#include <algorithm>

namespace sslv {

void Segment::process(const Params& params, const Lut& lut, const Mask& mask, const Image& image,
                      RunList& runs, RegionList& regions) noexcept {
  const ImageView& view = image.view();
  runs.cell_px = is_bayer(view.format) ? 2 : 1;
  runs.width = view.width / runs.cell_px;
  runs.height = view.height / runs.cell_px;

  if (!workers_ || workers_->threads() != params.threads - 1) {
    workers_ = std::make_unique<Workers>(params.threads - 1);
    // Several bands a thread: who wakes late or meets a crowd of runs takes fewer.
    bands_.resize(params.threads == 1 ? 1 : static_cast<std::size_t>(4 * params.threads));
  }
  const auto max_runs = static_cast<std::size_t>(params.runs.max_runs);
  const std::size_t room = max_runs + static_cast<std::size_t>(runs.width);
  for (Band& band : bands_) {
    if (band.room >= room) continue;
    band.runs = std::make_unique_for_overwrite<Run[]>(room);  // what is never written is never in memory
    band.room = room;
  }

  const Background& background = background_.follow(view, lut, mask);
  const auto bands = static_cast<int>(bands_.size());
  workers_->run(bands, [&](int i) {
    Band& band = bands_[static_cast<std::size_t>(i)];
    band.found = search_runs({view, &lut, &mask, &background, runs.height * i / bands,
                              runs.height * (i + 1) / bands, max_runs, band.runs.get()});
  });

  runs.runs.reserve(max_runs);
  runs.runs.clear();
  runs.capped = false;
  BackgroundUse use;
  for (const Band& band : bands_) {
    const std::size_t taken = std::min(band.found.runs, max_runs - runs.runs.size());
    runs.runs.insert(runs.runs.end(), band.runs.get(), band.runs.get() + taken);
    runs.capped |= taken < band.found.runs;
    use.blocks += band.found.use.blocks;
    use.odd_blocks += band.found.use.odd_blocks;
  }
  background_.note(use);
  find_regions_.process(params.regions, runs, regions);
}

}  // namespace sslv
