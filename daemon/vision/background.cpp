// SPDX-License-Identifier: Apache-2.0
#include "vision/background.h"

#include "image/color.h"
#include "vision/segment_kernel.h"

#include <algorithm>
#include <span>

namespace sslv {
namespace {

constexpr int kSamplesPerFrame = 64;
constexpr int kSamplesAtOnce = 1'024;  // for the first image
// Number of frames after which the boxes of a new table are regrown. It doubles with each growth, because the
// samples then cover more of the variation in light.
constexpr int kFirstFramesBetween = 8, kMaxFramesBetween = 1'024;
constexpr int kBins = BackgroundFollower::kBins, kBinWidth = 256 / kBins;
using Bins = BackgroundFollower::Bins;

/// The colour of the cell at (x, y), approximated for sampling; threshold.cpp computes it exactly.
Yuv color_at(const ImageView& image, int x, int y) {
  const std::uint8_t* row = image.row(y);
  switch (image.format) {
    case PixelFormat::kUyvy: return {row[x * 2 + 1], row[x / 2 * 4], row[x / 2 * 4 + 2]};
    case PixelFormat::kYuyv: return {row[x * 2], row[x / 2 * 4 + 1], row[x / 2 * 4 + 3]};
    case PixelFormat::kRgb24: return to_yuv({row[x * 3], row[x * 3 + 1], row[x * 3 + 2]});
    case PixelFormat::kBgr24: return to_yuv({row[x * 3 + 2], row[x * 3 + 1], row[x * 3]});
    case PixelFormat::kMono8: return {row[x], 128, 128};
    default: break;
  }
  const std::uint8_t* quad = image.row(y & ~1) + (x & ~1);
  const std::uint8_t* lower = quad + image.stride_bytes;
  switch (image.format) {
    case PixelFormat::kBayerRg8: return to_yuv({quad[0], quad[1], lower[1]});
    case PixelFormat::kBayerGr8: return to_yuv({quad[1], quad[0], lower[0]});
    case PixelFormat::kBayerGb8: return to_yuv({lower[0], quad[0], quad[1]});
    default: return to_yuv({lower[1], quad[1], quad[0]});
  }
}

/// A box of table blocks. Sides are inclusive.
struct Box {
  std::array<std::array<int, 2>, 3> sides;  // low and high of U, V, Y

  bool contains(const Bins& bins) const {
    for (std::size_t k = 0; k < 3; ++k) {
      if (bins[k] < sides[k][0] || bins[k] > sides[k][1]) return false;
    }
    return true;
  }
};

/// One of a box's six faces.
struct Face {
  std::size_t channel;
  std::size_t end;  // 0: low, 1: high
};
constexpr std::array<Face, 6> kFaces{{{2, 0}, {2, 1}, {0, 0}, {0, 1}, {1, 0}, {1, 1}}};

/// Grows a box within the blocks of one label.
class BoxGrower {
 public:
  BoxGrower(const std::uint64_t* uniform, const Bins& seed) : uniform_(uniform) {
    for (std::size_t k = 0; k < 3; ++k) box_.sides[k] = {seed[k], seed[k]};
  }

  /// Grows as far as possible, first towards the colours of `samples`.
  Box grow(std::span<const Bins> samples) {
    std::array<bool, kFaces.size()> stuck{};
    for (;;) {
      const std::array<int, kFaces.size()> scores = scores_for(samples);
      std::size_t best = kFaces.size();
      int most = 0;
      for (std::size_t i = 0; i < kFaces.size(); ++i) {
        if (stuck[i] || scores[i] <= most) continue;
        most = scores[i];
        best = i;
      }
      if (best == kFaces.size()) break;
      // A larger box grows in larger steps.
      const auto& side = box_.sides[kFaces[best].channel];
      int steps = 1 + (side[1] - side[0]) / 4;
      while (steps > 0 && !push(kFaces[best], steps)) steps /= 2;
      stuck[best] = steps == 0;
    }
    // Then evenly in all directions, because the light will change.
    for (bool pushed = true; pushed;) {
      pushed = false;
      for (const Face& face : kFaces) pushed |= push(face, 1);
    }
    return box_;
  }

 private:
  /// Gain of pushing each face by a step: near samples count more than distant ones.
  std::array<int, kFaces.size()> scores_for(std::span<const Bins> samples) const {
    constexpr auto kWorth = [] {
      std::array<int, 3 * kBins> worth{};
      for (int steps = 1; steps < 3 * kBins; ++steps)
        worth[static_cast<std::size_t>(steps)] = 65'536 / (steps * steps);
      return worth;
    }();
    std::array<int, kFaces.size()> scores{};
    for (const Bins& sample : samples) {
      std::array<int, kFaces.size()> beyond;
      int steps = 0;
      for (std::size_t f = 0; f < kFaces.size(); ++f) {
        const auto& [channel, end] = kFaces[f];
        const int distance =
            end == 0 ? box_.sides[channel][0] - sample[channel] : sample[channel] - box_.sides[channel][1];
        beyond[f] = std::max(distance, 0);
        steps += beyond[f];
      }
      const int worth = kWorth[static_cast<std::size_t>(steps)];
      for (std::size_t f = 0; f < kFaces.size(); ++f) scores[f] += beyond[f] > 0 ? worth : 0;
    }
    return scores;
  }

  bool push(const Face& face, int steps) {
    int& side = box_.sides[face.channel][face.end];
    Box slab = box_;
    const int near = face.end == 0 ? side - 1 : side + 1, far = face.end == 0 ? side - steps : side + steps;
    if (far < 0 || far >= kBins) return false;
    slab.sides[face.channel] = {std::min(near, far), std::max(near, far)};
    if (!is_uniform(slab)) return false;
    side = far;
    return true;
  }

  bool is_uniform(const Box& box) const {
    const auto& [u, v, y] = box.sides;
    const std::uint64_t wanted = (~std::uint64_t{0} >> (kBins - 1 - (y[1] - y[0]))) << y[0];
    for (int i = u[0]; i <= u[1]; ++i) {
      for (int j = v[0]; j <= v[1]; ++j) {
        if ((uniform_[i * kBins + j] & wanted) != wanted) return false;
      }
    }
    return true;
  }

  const std::uint64_t* uniform_;
  Box box_;
};

}  // namespace

int BackgroundFollower::random(int below) {
  random_ = random_ * 1664525 + 1013904223;  // Numerical Recipes' generator, whose upper bits are good
  return static_cast<int>((std::uint64_t{random_} * static_cast<std::uint64_t>(below)) >> 32);
}

void BackgroundFollower::sample(const ImageView& image, const Mask& mask, int count) {
  for (int i = 0; i < count; ++i) {
    const int x = random(image.width), y = random(image.height);
    const auto intervals = mask.row(y, 1);
    if (std::none_of(intervals.begin(), intervals.end(),
                     [x](const auto& interval) { return x >= interval.begin && x < interval.end; }))
      continue;
    const Yuv c = color_at(image, x, y);
    samples_[sampled_++ % kSamples] = {static_cast<std::uint8_t>(c.u / kBinWidth),
                                       static_cast<std::uint8_t>(c.v / kBinWidth),
                                       static_cast<std::uint8_t>(c.y / kBinWidth)};
  }
}

Label BackgroundFollower::commonest_label(const LutTable& yuv) const {
  std::array<std::uint32_t, 256> counts{};
  for (std::size_t i = 0; i < std::min(sampled_, kSamples); ++i) {
    const auto& [u, v, y] = samples_[i];
    ++counts[yuv.blocks[static_cast<std::size_t>((u * kBins + v) * kBins + y)]];
  }
  counts[LutTable::kMixed] = 0;
  return static_cast<Label>(std::max_element(counts.begin(), counts.end()) - counts.begin());
}

/// Finds the blocks that boxes may contain.
void BackgroundFollower::take_table(const Lut& lut, PixelFormat format, Label label) {
  background_.label = label;
  background_.boxes = 0;
  find_uniform_blocks(lut.yuv(), background_.label, yuv_blocks_.data());
  if (is_yuv422(format) || format == PixelFormat::kMono8) {
    background_.blocks = yuv_blocks_;
  } else {
    find_uniform_blocks(lut.rgb(), background_.label, background_.blocks.data());
  }
  lut_id_ = lut.id();
  format_ = format;
}

bool BackgroundFollower::in_background(const Bins& bins) const {
  return (yuv_blocks_[static_cast<std::size_t>(bins[0] * kBins + bins[1])] >> bins[2] & 1) != 0;
}

void BackgroundFollower::begin_growth() {
  growth_.goes_on = true;
  growth_.is_first = background_.boxes == 0;
  growth_.boxes = 0;
  growth_.all = std::min(sampled_, kSamples);
  const auto end = samples_.begin() + static_cast<std::ptrdiff_t>(growth_.all);
  growth_.left_count =
      static_cast<std::size_t>(std::copy_if(samples_.begin(), end, growth_.left.begin(),
                                            [this](const Bins& bins) { return in_background(bins); }) -
                               growth_.left.begin());
}

/// Grows the next box, around as many of the remaining samples as possible.
void BackgroundFollower::grow_box() {
  // A box with fewer samples costs more than it saves.
  constexpr std::size_t kMinShare = 500;  // a box must contain more than 1 / kMinShare of all samples
  constexpr std::size_t kLookedAt = 128;  // number of samples that guide the growth
  constexpr int kSeeds = 3;               // number of seeds; the best box is used

  const std::span<Bins> rest(growth_.left.data(), growth_.left_count);
  Box best{};
  std::size_t most = 0;
  if (growth_.boxes < Background::kMaxBoxes && rest.size() * kMinShare > growth_.all) {
    std::array<Bins, kLookedAt> room;
    const std::span<Bins> some(room.data(), std::min(rest.size(), kLookedAt));
    for (std::size_t i = 0; i < some.size(); ++i) some[i] = rest[i * rest.size() / some.size()];
    const auto try_seed = [&](const Bins& seed) {
      const Box box = BoxGrower(yuv_blocks_.data(), seed).grow(some);
      const auto inside = static_cast<std::size_t>(
          std::count_if(rest.begin(), rest.end(), [&](const Bins& bins) { return box.contains(bins); }));
      if (inside <= most) return;
      most = inside;
      best = box;
    };
    // Seeds: random samples, and the median of the samples in each channel.
    for (int k = 1; k < kSeeds; ++k)
      try_seed(some[static_cast<std::size_t>(random(static_cast<int>(some.size())))]);
    Bins middle{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto at = some.begin() + static_cast<std::ptrdiff_t>(some.size() / 2);
      std::nth_element(some.begin(), at, some.end(),
                       [k](const Bins& a, const Bins& b) { return a[k] < b[k]; });
      middle[k] = (*at)[k];
    }
    if (in_background(middle)) try_seed(middle);
  }
  growth_.goes_on = most * kMinShare > growth_.all;
  if (growth_.goes_on) {
    growth_.left_count = static_cast<std::size_t>(
        std::remove_if(rest.begin(), rest.end(), [&](const Bins& bins) { return best.contains(bins); }) -
        rest.begin());
    ColorBox& colors = growth_.box[growth_.boxes++];
    for (std::size_t k = 0; k < 3; ++k) {
      colors.low[k] = static_cast<std::uint8_t>(best.sides[k][0] * kBinWidth);
      colors.high[k] = static_cast<std::uint8_t>(best.sides[k][1] * kBinWidth + kBinWidth - 1);
    }
  }
  if (growth_.goes_on && !growth_.is_first) return;
  background_.boxes = growth_.boxes;
  background_.box = growth_.box;
}

const Background& BackgroundFollower::follow(const ImageView& image, const Lut& lut,
                                             const Mask& mask) noexcept {
  const bool is_new = lut_id_ != lut.id() || format_ != image.format;
  sample(image, mask, sampled_ == 0 ? kSamplesAtOnce : kSamplesPerFrame);
  if (is_new) frames_between_ = kFirstFramesBetween;
  if (is_new || ++age_ >= frames_between_) {
    if (!is_new) frames_between_ = std::min(2 * frames_between_, kMaxFramesBetween);
    const Label label = commonest_label(lut.yuv());
    if (is_new || label != background_.label) take_table(lut, image.format, label);
    begin_growth();
    age_ = 0;
  }
  if (growth_.goes_on) grow_box();
  return background_;
}

void BackgroundFollower::note(const BackgroundUse& use) noexcept {
  if (use.blocks == 0) return;
  constexpr int kFramesBetweenTries = 64;
  if (background_.first_alone) {
    background_.first_alone = 3 * use.odd_blocks < 2 * use.blocks;
    frames_without_first_ = 0;
  } else {
    background_.first_alone = ++frames_without_first_ % kFramesBetweenTries == 0;
  }
}

}  // namespace sslv
