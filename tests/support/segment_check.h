// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/segment.h"
#include "vision/threshold.h"

#include <string>

namespace sslv {

/// What the plain stages make of a picture.
class PlainSegmentation {
 public:
  void process(const Segment::Params& params, const Lut& lut, const Mask& mask, const Image& image) {
    threshold_.process({}, lut, mask, image, labels);
    find_runs_.process(params.runs, labels, runs);
    find_regions_.process(params.regions, runs, regions);
  }
  LabelImage labels;
  RunList runs;
  RegionList regions;

 private:
  Threshold threshold_;
  FindRuns find_runs_;
  FindRegions find_regions_;
};

/// What differs between two results, bit by bit; empty when nothing does.
inline std::string difference(const PlainSegmentation& plain, const RunList& runs,
                              const RegionList& regions) {
  if (plain.runs.width != runs.width || plain.runs.height != runs.height ||
      plain.runs.cell_px != runs.cell_px)
    return "size of the runs' picture";
  if (plain.runs.capped != runs.capped) return "runs.capped";
  const auto same_run = [](const Run& a, const Run& b) {
    return a.y == b.y && a.x_begin == b.x_begin && a.x_end == b.x_end && a.label == b.label;
  };
  const auto show = [](const Run& run) {
    return "y " + std::to_string(run.y) + " x " + std::to_string(run.x_begin) + " .. " +
           std::to_string(run.x_end) + " label " + std::to_string(run.label);
  };
  for (std::size_t i = 0; i < std::max(plain.runs.runs.size(), runs.runs.size()); ++i) {
    if (i == plain.runs.runs.size()) return "one run too many: " + show(runs.runs[i]);
    if (i == runs.runs.size()) return "a run is missing: " + show(plain.runs.runs[i]);
    if (!same_run(plain.runs.runs[i], runs.runs[i]))
      return "run " + std::to_string(i) + ": plain " + show(plain.runs.runs[i]) + ", here " +
             show(runs.runs[i]);
  }
  if (plain.regions.capped != regions.capped) return "regions.capped";
  if (plain.regions.begin != regions.begin) return "regions.begin";
  if (plain.regions.regions.size() != regions.regions.size()) return "number of regions";
  for (std::size_t i = 0; i < regions.regions.size(); ++i) {
    const Region &a = plain.regions.regions[i], &b = regions.regions[i];
    if (a.label != b.label || a.area_px != b.area_px || a.left != b.left || a.top != b.top ||
        a.right != b.right || a.bottom != b.bottom || a.x_px != b.x_px || a.y_px != b.y_px ||
        a.first_run != b.first_run)
      return "region " + std::to_string(i);
  }
  return {};
}

}  // namespace sslv
