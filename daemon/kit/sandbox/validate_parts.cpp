// SPDX-License-Identifier: Apache-2.0
#include "kit/sandbox/validate_parts.h"

#include "vision/flood_cut.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace sslv::sandbox {
namespace {

constexpr int kMaxImagePx = 16'384;  // is_valid_size()

bool fits_image(int width, int height, int cell_px, const ImageView& image) {
  if (width == 0 && height == 0) return true;
  return (cell_px == 1 || cell_px == 2) && width > 0 && height > 0 && width * cell_px <= image.width &&
         height * cell_px <= image.height && width <= kMaxImagePx && height <= kMaxImagePx;
}

void empty(LabelImage& part) {
  part.width = part.height = 0;
}
void empty(RunList& part) {
  part.width = part.height = 0;
  part.runs.clear();
  part.flood = {};
  part.cut.clear();
}
void empty(RegionList& part) {
  part.regions.clear();
  part.begin = {};
  part.capped = false;
}
void empty(RobotList& part) {
  part.robots.clear();
  part.second_robots.clear();
  part.misses.clear();
  part.capped = false;
}
void empty(BallList& part) {
  part.balls.clear();
  part.capped = false;
}
void empty(FrameInfo&) {}
void empty(Image&) {}
void empty(ArrivedSightings&) {}
void empty(CameraSightings& part) {
  part.is_taken = false;
  part.robots.clear();
  part.balls.clear();
}
void empty(LeftOut&) {}
void empty(ImageTime& part) {
  part = {};
}
void empty(Observations& part) {
  part.robots.clear();
  part.balls.clear();
}
void empty(CameraAgreement&) {}
void empty(TrackedField& part) {
  part.robots.clear();
  part.balls.clear();
  part.kick.reset();
}

template <class Floor>
void make_parts_empty(typename Floor::Frame& frame, PartSet written) {
  std::size_t i = 0;
  std::apply([&](const auto&... part) { ((written[i++] ? empty(frame.*part.member) : void()), ...); },
             Floor::kParts);
}

}  // namespace

bool is_valid(const LabelImage& part, const Frame& now) {
  if (!fits_image(part.width, part.height, part.cell_px, now.image.view())) return false;
  if (part.labels.size() < static_cast<std::size_t>(part.width) * static_cast<std::size_t>(part.height))
    return false;
  // Not all_of(): without an early exit, the compiler vectorizes the loop.
  Label largest = 0;
  for (const Label one : part.labels) largest = std::max(largest, one);
  return largest < label::kMaxCount;
}

bool is_valid(const RunList& part, const Frame& now) {
  if (!fits_image(part.width, part.height, part.cell_px, now.image.view())) return false;
  if (part.runs.size() > kMaxRuns || part.flood.label >= label::kMaxCount) return false;
  const auto blocks = [](int cells) {
    return static_cast<std::size_t>((cells + FloodCut::kBlockCells - 1) / FloodCut::kBlockCells);
  };
  if (!part.cut.empty() && part.cut.size() != blocks(part.width) * blocks(part.height)) return false;
  const Run* last = nullptr;
  for (const Run& run : part.runs) {
    if (run.label == label::kClear || run.label >= label::kMaxCount || run.y >= part.height ||
        run.x_begin >= run.x_end || run.x_end > part.width)
      return false;
    if (last != nullptr && (run.y < last->y || (run.y == last->y && run.x_begin < last->x_end))) return false;
    last = &run;
  }
  return true;
}

bool is_valid(const RegionList& part, const Frame& now) {
  if (part.regions.size() > kMaxRegions || part.begin.back() != part.regions.size()) return false;
  if (!std::is_sorted(part.begin.begin(), part.begin.end())) return false;
  for (std::size_t one = 0; one + 1 < part.begin.size(); ++one) {
    for (std::size_t i = part.begin[one]; i < part.begin[one + 1]; ++i) {
      const Region& region = part.regions[i];
      if (region.label != one || region.label >= label::kMaxCount || region.left > region.right ||
          region.top > region.bottom || region.right >= now.image.view().width ||
          region.bottom >= now.image.view().height ||
          !(region.x_px >= region.left && region.x_px <= region.right + 1.F) ||
          !(region.y_px >= region.top && region.y_px <= region.bottom + 1.F) || region.area_px == 0)
        return false;
      if (!now.runs.runs.empty() && region.first_run >= now.runs.runs.size()) return false;
    }
  }
  return true;
}

void make_empty(Frame& frame, PartSet written) {
  make_parts_empty<CameraFloor>(frame, written);
}
void make_empty(FieldFrame& frame, PartSet written) {
  make_parts_empty<FieldFloor>(frame, written);
}

}  // namespace sslv::sandbox
