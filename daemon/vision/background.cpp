// SPDX-License-Identifier: Apache-2.0
#include "vision/background.h"

#include <algorithm>
#include <cstdlib>
#include <numeric>

namespace sslv {
namespace {

constexpr int kSamplesPerFrame = 64;
constexpr int kSamplesAtOnce = 1'024;  // when nothing is known yet
constexpr int kFramesBetween = 128;    // how often the box is grown anew
constexpr int kNearBins = 10;          // from the median: 40 of 256 levels

using Channels = std::array<std::uint8_t, 3>;

/// The colour of the cell at (x, y), as LutTable names its channels. For samples: threshold.cpp is exact.
Channels color_at(const ImageView& image, int x, int y) {
  const std::uint8_t* row = image.row(y);
  switch (image.format) {
    case PixelFormat::kUyvy: return {row[x / 2 * 4], row[x / 2 * 4 + 2], row[x * 2 + 1]};
    case PixelFormat::kYuyv: return {row[x / 2 * 4 + 1], row[x / 2 * 4 + 3], row[x * 2]};
    case PixelFormat::kRgb24: return {row[x * 3], row[x * 3 + 2], row[x * 3 + 1]};
    case PixelFormat::kBgr24: return {row[x * 3 + 2], row[x * 3], row[x * 3 + 1]};
    case PixelFormat::kMono8: return {128, 128, row[x]};
    default: break;
  }
  const std::uint8_t* quad = image.row(y & ~1) + (x & ~1);
  const std::uint8_t* lower = quad + image.stride_bytes;
  switch (image.format) {
    case PixelFormat::kBayerRg8: return {quad[0], lower[1], quad[1]};
    case PixelFormat::kBayerGr8: return {quad[1], lower[0], quad[0]};
    case PixelFormat::kBayerGb8: return {lower[0], quad[1], quad[0]};
    default: return {lower[1], quad[0], quad[1]};
  }
}

constexpr int kBins = BackgroundFollower::kBins, kStep = 256 / kBins;
constexpr std::size_t kChromaBins = std::size_t{1} << LutTable::kChromaBits;
using Counts = BackgroundFollower::Counts;
using Bins = BackgroundFollower::Bins;

/// A box of table blocks while it grows. Sides are inclusive.
struct Box {
  std::array<std::array<int, 2>, 3> sides;  // low and high of a, b, c
};

/// One of a box's six faces.
struct Face {
  std::size_t channel;
  std::size_t end;  // 0: low, 1: high
  int step() const { return end == 0 ? -1 : 1; }
};
constexpr std::array<Face, 6> kFaces{{{0, 0}, {0, 1}, {1, 0}, {1, 1}, {2, 0}, {2, 1}}};

bool is_uniform(const LutTable& table, const Box& box, Label label) {
  const auto& [a_side, b_side, c_side] = box.sides;
  for (int a = a_side[0]; a <= a_side[1]; ++a) {
    for (int b = b_side[0]; b <= b_side[1]; ++b) {
      const Label* row = table.blocks.data() + (a * kBins + b) * kBins;
      for (int c = c_side[0]; c <= c_side[1]; ++c) {
        if (row[c] != label) return false;
      }
    }
  }
  return true;
}

/// How much of the pictures lies at and beyond `value`, seen from the box.
std::uint32_t mass_from(const Counts& counts, const Face& face, int value) {
  std::uint32_t sum = 0;
  for (int i = value; i >= 0 && i < kBins; i += face.step())
    sum += counts[face.channel][static_cast<std::size_t>(i)];
  return sum;
}

/// Draws in another face of `box` as far as it takes for the slab in front of `face` to be all of one label,
/// if that loses less of the pictures than the slab wins. `core` must stay in.
bool make_room(const LutTable& table, Label label, const Counts& counts, const Box& core, const Face& face,
               const Box& slab, Box& box) {
  std::uint32_t least = counts[face.channel][static_cast<std::size_t>(slab.sides[face.channel][0])];
  const Face* best = nullptr;
  int best_side = 0;
  for (const Face& other : kFaces) {
    if (other.channel == face.channel) continue;
    Box smaller = slab;
    int& side = smaller.sides[other.channel][other.end];
    std::uint32_t lost = 0;
    while (side != core.sides[other.channel][other.end] && lost < least) {
      lost += counts[other.channel][static_cast<std::size_t>(side)];
      side -= other.step();
      if (lost < least && is_uniform(table, smaller, label)) {
        least = lost;
        best = &other;
        best_side = side;
      }
    }
  }
  if (best == nullptr) return false;
  box.sides[best->channel][best->end] = best_side;
  return true;
}

/// The largest box around `median` that is all of `label`, as the pictures' colours go.
Box grow_box(const LutTable& table, Label label, const Bins& median, const Counts& all, const Counts& near) {
  Box core{};
  for (std::size_t k = 0; k < 3; ++k) core.sides[k] = {median[k], median[k]};
  Box box = core;
  // First around the commonest colour; then, if it costs nothing, towards others, such as the lines'.
  for (const Counts* counts : {&near, &all}) {
    std::array<bool, kFaces.size()> stuck{};
    for (;;) {
      // The face with the most pixels right beyond it, and then the most beyond it at all.
      std::size_t best = kFaces.size();
      std::uint32_t most = 0;
      for (std::size_t i = 0; i < kFaces.size(); ++i) {
        const Face& face = kFaces[i];
        const int next = box.sides[face.channel][face.end] + face.step();
        if (stuck[i] || next < 0 || next >= kBins) continue;
        const std::uint32_t score =
            16 * (*counts)[face.channel][static_cast<std::size_t>(next)] + mass_from(*counts, face, next);
        if (score > most) {
          most = score;
          best = i;
        }
      }
      if (best == kFaces.size()) break;

      const Face& face = kFaces[best];
      int& side = box.sides[face.channel][face.end];
      Box slab = box;
      slab.sides[face.channel] = {side + face.step(), side + face.step()};
      if (is_uniform(table, slab, label) ||
          (counts == &near && make_room(table, label, near, core, face, slab, box))) {
        side += face.step();
      } else {
        stuck[best] = true;
      }
    }
  }
  return box;
}

bool contains(const ColorBox& box, const Channels& color) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (color[k] < box.low[k] || color[k] > box.high[k]) return false;
  }
  return true;
}

/// The label of the greys 8 * bin .. 8 * bin + 7, or LutTable::kMixed.
Label grey_label(const LutTable& table, std::size_t bin) {
  const Label first = table.of(128, 128, static_cast<std::uint8_t>(8 * bin));
  for (std::size_t y = 8 * bin + 1; y < 8 * bin + 8; ++y) {
    if (table.of(128, 128, static_cast<std::uint8_t>(y)) != first) return LutTable::kMixed;
  }
  return first;
}

bool is_yuv(PixelFormat format) {
  return is_yuv422(format) || format == PixelFormat::kMono8;
}

}  // namespace

void BackgroundFollower::Mode::add(const Bins& bins) {
  bool is_near = true;
  for (std::size_t k = 0; k < 3; ++k) {
    ++all[k][static_cast<std::size_t>(bins[k])];
    is_near = is_near && std::abs(bins[k] - median[k]) <= kNearBins;
  }
  for (std::size_t k = 0; is_near && k < 3; ++k) ++near[k][static_cast<std::size_t>(bins[k])];
}

void BackgroundFollower::Mode::find_median() {
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t total = std::accumulate(all[k].begin(), all[k].end(), 0U);
    std::uint32_t sum = 0;
    std::size_t bin = 0;
    while (bin < kBins - 1 && 2 * (sum + all[k][bin]) < total) sum += all[k][bin++];
    median[k] = static_cast<int>(bin);
  }
}

void BackgroundFollower::Mode::fade() {
  for (Counts* counts : {&all, &near}) {
    for (auto& of_channel : *counts) {
      for (std::uint32_t& count : of_channel) count /= 2;
    }
  }
}

void BackgroundFollower::sample(const ImageView& image, const Mask& mask, int count) {
  const auto random = [this](int below) {
    random_ = random_ * 1664525 + 1013904223;  // Numerical Recipes' generator: the upper bits are good
    return static_cast<int>((std::uint64_t{random_} * static_cast<std::uint64_t>(below)) >> 32);
  };
  for (int i = 0; i < count; ++i) {
    const int x = random(image.width), y = random(image.height);
    const auto intervals = mask.row(y, 1);
    if (std::none_of(intervals.begin(), intervals.end(),
                     [x](const auto& interval) { return x >= interval.begin && x < interval.end; }))
      continue;
    const Channels color = color_at(image, x, y);
    const Bins bins{color[0] / kStep, color[1] / kStep, color[2] / kStep};
    modes_[0].add(bins);
    if (background_.boxes > 0 && !contains(background_.box[0], color)) modes_[1].add(bins);
  }
}

void BackgroundFollower::grow(const LutTable& table, PixelFormat format) {
  background_ = {};
  find_boxes(table);
  for (std::size_t a = 0; a < kChromaBins; ++a) {
    for (std::size_t b = 0; b < kChromaBins; ++b) {
      const Label label =
          format == PixelFormat::kMono8 ? grey_label(table, a) : table.chroma[a * kChromaBins + b];
      if (label == background_.label) continue;
      std::uint8_t& bits = background_.odd_chroma[b / 8][a];
      bits = static_cast<std::uint8_t>(bits | 1U << b % 8);
    }
  }
}

void BackgroundFollower::find_boxes(const LutTable& table) {
  for (Mode& mode : modes_) {
    mode.find_median();
    const auto& [a, b, c] = mode.median;
    const Label label = table.blocks[static_cast<std::size_t>((a * kBins + b) * kBins + c)];
    // The second box is of use only beside the first and with its label.
    if (label == LutTable::kMixed || (background_.boxes == 1 && label != background_.label)) return;
    const Box box = grow_box(table, label, mode.median, mode.all, mode.near);
    ColorBox& colors = background_.box[static_cast<std::size_t>(background_.boxes)];
    for (std::size_t k = 0; k < 3; ++k) {
      colors.low[k] = static_cast<std::uint8_t>(box.sides[k][0] * kStep);
      colors.high[k] = static_cast<std::uint8_t>(box.sides[k][1] * kStep + kStep - 1);
    }
    background_.label = label;
    ++background_.boxes;
  }
}

const Background& BackgroundFollower::follow(const ImageView& image, const Lut& lut,
                                             const Mask& mask) noexcept {
  const LutTable& table = is_yuv(image.format) ? lut.yuv() : lut.rgb();
  if (lut_id_ == 0 || format_ != image.format || fits_badly_) {
    background_ = {};
    modes_ = {};
    // First where the colours are, then how they spread around that; the same outside the first box.
    for (int round = 0; round < 3; ++round) {
      sample(image, mask, kSamplesAtOnce);
      grow(table, image.format);
    }
  } else {
    sample(image, mask, kSamplesPerFrame);
    if (lut_id_ == lut.id() && ++age_ < kFramesBetween) return background_;
    grow(table, image.format);
  }
  format_ = image.format;
  lut_id_ = lut.id();
  age_ = 0;
  for (Mode& mode : modes_) mode.fade();
  return background_;
}

void BackgroundFollower::note(std::size_t blocks, std::size_t odd_blocks, std::size_t in_second) noexcept {
  if (blocks == 0) return;
  const double odd_share = static_cast<double>(odd_blocks) / static_cast<double>(blocks);
  if (age_ == 0) odd_share_at_first_ = odd_share;
  fits_badly_ = odd_share > 1.5 * odd_share_at_first_ + 0.1;
  // A test that few blocks pass costs more than it saves.
  if (4 * in_second < odd_blocks) background_.boxes = std::min(background_.boxes, 1);
}

}  // namespace sslv
