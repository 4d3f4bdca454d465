// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/color.h"
#include "vision/segment.h"
#include "vision/threshold.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <memory>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace sslv {

inline constexpr Rgb kCarpet{40, 105, 70};
inline constexpr std::array<Rgb, 6> kColors{
    {{238, 108, 32}, {224, 198, 38}, {28, 92, 196}, {230, 64, 150}, {108, 212, 62}, {205, 205, 200}}};

/// Typical and extreme tables.
inline const std::vector<std::shared_ptr<const Lut>>& test_luts() {
  static const auto made = [] {
    std::vector<std::shared_ptr<const Lut>> all{std::make_shared<const Lut>()};
    const auto add = [&](auto label_of, int bits = 7) {
      ColorTable table(bits);
      for (std::size_t cell = 0; cell < table.labels.size(); ++cell)
        table.labels[cell] = label_of(table.color_of(cell));
      all.push_back(std::make_shared<const Lut>(std::move(table)));
    };
    const auto near_color = [](Yuv c, int reach) {
      for (std::size_t i = 0; i < kColors.size(); ++i) {
        const Yuv k = to_yuv(kColors[i]);
        if (std::abs(c.u - k.u) < reach && std::abs(c.v - k.v) < reach && std::abs(c.y - k.y) < 2 * reach)
          return static_cast<Label>(2 + i);
      }
      return label::kClear;
    };
    add([&](Yuv c) { return near_color(c, 20); });
    add([&](Yuv c) {  // everything else is labelled carpet
      const Label label = near_color(c, 30);
      return label != label::kClear ? label : label::kField;
    });
    add([](Yuv) { return label::kOrange; });
    std::mt19937 random(7);
    add([&](Yuv) { return static_cast<Label>(random() % 10); });
    add([&](Yuv) { return static_cast<Label>(random() % 200 == 0 ? 3 : 0); });
    add([](Yuv c) { return static_cast<Label>((c.u / 8 + c.v / 8 + c.y / 32) % 3); });
    add([&](Yuv c) { return near_color(c, 20); }, 8);
    add([&](Yuv) { return static_cast<Label>(random() % 50 == 0 ? 31 : 0); }, 8);
    add([&](Yuv c) { return near_color(c, 25); }, 5);
    return all;
  }();
  return made;
}

/// Results of the plain stages for an image.
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

/// Describes the first exact difference between two results; empty if there is none.
inline std::string difference(const PlainSegmentation& plain, const RunList& runs,
                              const RegionList& regions) {
  if (plain.runs.width != runs.width || plain.runs.height != runs.height ||
      plain.runs.cell_px != runs.cell_px)
    return "size of the runs' picture";
  const Flood &was = plain.runs.flood, &is = runs.flood;
  if (std::tie(was.blocks, was.label, was.cell_px, was.left, was.top, was.right, was.bottom) !=
      std::tie(is.blocks, is.label, is.cell_px, is.left, is.top, is.right, is.bottom))
    return "runs.flood";
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
