// SPDX-License-Identifier: Apache-2.0
#include "vision/segment.h"

#include "base/log.h"

#include <algorithm>

namespace sslv {

/// Splits the image into parts for the threads.
void Segment::share_out(int threads, const RunList& picture) {
  if (threads_ != threads) {
    threads_ = threads;
    workers_ = std::make_unique<Workers>(threads - 1);
    if (const int had = workers_->threads() + 1; had < threads)
      log::warning("segment: continues with {} of {} threads; the system provides no more", had, threads);
    // Several parts per thread, so that a thread that wakes late or finds many runs processes fewer parts.
    parts_.resize(threads == 1 ? 1 : static_cast<std::size_t>(4 * threads));
    found_.resize(parts_.size());
  }
  const auto count = static_cast<int>(parts_.size());
  const int blocks = (picture.height + FloodCut::kBlockCells - 1) / FloodCut::kBlockCells;
  for (int i = 0; i < count; ++i) {
    Part& part = parts_[static_cast<std::size_t>(i)];
    part.row_begin = blocks * i / count * FloodCut::kBlockCells;
    part.row_end = std::min(blocks * (i + 1) / count * FloodCut::kBlockCells, picture.height);
    const std::size_t room =
        FloodCut::room(picture.width, std::max(0, part.row_end - part.row_begin), kMaxPendingRuns);
    if (part.room < room) {
      part.runs = std::make_unique_for_overwrite<Run[]>(room);  // pages that are never written take no memory
      part.room = room;
    }
  }
}

void Segment::process(const Params& params, const Lut& lut, const Mask& mask, const Image& image,
                      RunList& runs, RegionList& regions) noexcept {
  const ImageView& view = image.view();
  runs.cell_px = is_bayer(view.format) ? 2 : 1;
  runs.width = view.width / runs.cell_px;
  runs.height = view.height / runs.cell_px;
  share_out(params.threads, runs);
  flood_cut_.begin(runs.width, runs.height);

  const Background& background = background_.follow(view, lut, mask);
  workers_->run(static_cast<int>(parts_.size()), [&](int i) {
    Part& part = parts_[static_cast<std::size_t>(i)];
    FloodCut::Band& found = found_[static_cast<std::size_t>(i)];
    found = {part.runs.get()};
    part.use =
        search_runs({view, &lut, &mask, &background, part.row_begin, part.row_end, &flood_cut_, &found});
  });

  BackgroundUse use;
  for (const Part& part : parts_) {
    use.blocks += part.use.blocks;
    use.odd_blocks += part.use.odd_blocks;
  }
  background_.note(use);
  flood_cut_.finish(found_, static_cast<std::size_t>(params.runs.max_runs), runs);
  find_regions_.process(params.regions, runs, regions);
}

}  // namespace sslv
