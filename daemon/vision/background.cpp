// SPDX-License-Identifier: Apache-2.0
#include "vision/background.h"

#include "image/color.h"
#include "vision/segment_kernel.h"

#include <algorithm>
#include <cstdlib>

namespace sslv {
namespace {

constexpr int kSamplesPerFrame = 64;
constexpr int kSamplesAtOnce = 1'024;   // when nothing is known yet
constexpr int kFramesBetween = 128;     // how often the boxes are grown anew
constexpr int kLeastFramesBetween = 8;  // also when they fit badly
constexpr int kBins = BackgroundFollower::kBins, kStep = 256 / kBins;
using Bins = BackgroundFollower::Bins;

/// The colour of the cell at (x, y). For samples: threshold.cpp is exact.
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

  /// As far as it can, first towards the colours of `samples`.
  Box grow(const Bins* samples, std::size_t count) {
    std::array<bool, kFaces.size()> stuck{};
    for (;;) {
      const std::array<int, kFaces.size()> scores = scores_for(samples, count);
      std::size_t best = kFaces.size();
      int most = 0;
      for (std::size_t i = 0; i < kFaces.size(); ++i) {
        if (stuck[i] || scores[i] <= most) continue;
        most = scores[i];
        best = i;
      }
      if (best == kFaces.size()) break;
      stuck[best] = !push(kFaces[best]);
    }
    // Then evenly: the light will change.
    for (bool pushed = true; pushed;) {
      pushed = false;
      for (const Face& face : kFaces) pushed |= push(face);
    }
    return box_;
  }

 private:
  /// How much it is worth to push each face by a step: near samples count more than distant ones.
  std::array<int, kFaces.size()> scores_for(const Bins* samples, std::size_t count) const {
    constexpr auto kWorth = [] {
      std::array<int, 3 * kBins> worth{};
      for (int steps = 1; steps < 3 * kBins; ++steps)
        worth[static_cast<std::size_t>(steps)] = 65'536 / (steps * steps);
      return worth;
    }();
    std::array<int, kFaces.size()> scores{};
    for (std::size_t i = 0; i < count; ++i) {
      std::array<int, kFaces.size()> beyond;
      int steps = 0;
      for (std::size_t f = 0; f < kFaces.size(); ++f) {
        const auto& [channel, end] = kFaces[f];
        const int distance = end == 0 ? box_.sides[channel][0] - samples[i][channel]
                                      : samples[i][channel] - box_.sides[channel][1];
        beyond[f] = std::max(distance, 0);
        steps += beyond[f];
      }
      const int worth = kWorth[static_cast<std::size_t>(steps)];
      for (std::size_t f = 0; f < kFaces.size(); ++f) scores[f] += beyond[f] > 0 ? worth : 0;
    }
    return scores;
  }

  bool push(const Face& face) {
    int& side = box_.sides[face.channel][face.end];
    const int next = side + (face.end == 0 ? -1 : 1);
    if (next < 0 || next >= kBins) return false;
    Box slab = box_;
    slab.sides[face.channel] = {next, next};
    if (!is_uniform(slab)) return false;
    side = next;
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
    const Yuv c = color_at(image, x, y);
    samples_[sampled_++ % kSamples] = {static_cast<std::uint8_t>(c.u / kStep),
                                       static_cast<std::uint8_t>(c.v / kStep),
                                       static_cast<std::uint8_t>(c.y / kStep)};
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

/// Takes over what boxes may hold.
void BackgroundFollower::take_table(const Lut& lut, PixelFormat format) {
  background_.label = commonest_label(lut.yuv());
  find_uniform_blocks(lut.yuv(), background_.label, yuv_blocks_.data());
  if (is_yuv422(format) || format == PixelFormat::kMono8) {
    background_.blocks = yuv_blocks_;
  } else {
    find_uniform_blocks(lut.rgb(), background_.label, background_.blocks.data());
  }
  lut_id_ = lut.id();
  format_ = format;
}

void BackgroundFollower::grow() {
  // A test that fewer pass costs more than it saves.
  constexpr std::size_t kLeastShare = 384;  // one in so many
  constexpr std::size_t kLookedAt = 256;    // samples are enough to grow towards

  background_.boxes = 0;
  std::array<Bins, kSamples> left;  // samples that could be in a box and are in none
  std::size_t count = 0, all = std::min(sampled_, kSamples);
  for (std::size_t i = 0; i < all; ++i) {
    const auto& [u, v, y] = samples_[i];
    if ((yuv_blocks_[static_cast<std::size_t>(u * kBins + v)] >> y & 1) != 0) left[count++] = samples_[i];
  }
  while (background_.boxes < Background::kMostBoxes && count * kLeastShare > all) {
    std::array<Bins, kLookedAt> some;
    const std::size_t looked_at = std::min(count, kLookedAt);
    for (std::size_t i = 0; i < looked_at; ++i) some[i] = left[i * count / looked_at];
    // Around the middle of them, channel by channel; if there is none of them there, around any.
    Bins seed = some[looked_at / 2];
    Bins middle{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto at = some.begin() + static_cast<std::ptrdiff_t>(looked_at / 2);
      std::nth_element(some.begin(), at, some.begin() + static_cast<std::ptrdiff_t>(looked_at),
                       [k](const Bins& a, const Bins& b) { return a[k] < b[k]; });
      middle[k] = (*at)[k];
    }
    if ((yuv_blocks_[static_cast<std::size_t>(middle[0] * kBins + middle[1])] >> middle[2] & 1) != 0)
      seed = middle;
    const Box box = BoxGrower(yuv_blocks_.data(), seed).grow(some.data(), looked_at);
    const auto rest = std::remove_if(left.begin(), left.begin() + static_cast<std::ptrdiff_t>(count),
                                     [&](const Bins& bins) { return box.contains(bins); });
    const auto still = static_cast<std::size_t>(rest - left.begin());
    if ((count - still) * kLeastShare <= all) break;
    count = still;
    ColorBox& colors = background_.box[background_.boxes++];
    for (std::size_t k = 0; k < 3; ++k) {
      colors.low[k] = static_cast<std::uint8_t>(box.sides[k][0] * kStep);
      colors.high[k] = static_cast<std::uint8_t>(box.sides[k][1] * kStep + kStep - 1);
    }
  }
}

const Background& BackgroundFollower::follow(const ImageView& image, const Lut& lut,
                                             const Mask& mask) noexcept {
  ++age_;
  const bool refresh = lut_id_ == 0 || (fits_badly_ && age_ >= kLeastFramesBetween);
  sample(image, mask, refresh ? kSamplesAtOnce : kSamplesPerFrame);
  if (refresh || lut_id_ != lut.id() || format_ != image.format || age_ >= kFramesBetween) {
    take_table(lut, image.format);
    grow();
    age_ = 0;
  }
  return background_;
}

void BackgroundFollower::note(const BackgroundUse& use) noexcept {
  if (use.blocks == 0) return;
  const double outside = static_cast<double>(use.candidates) / (64.0 * static_cast<double>(use.blocks));
  if (age_ == 0) outside_at_first_ = outside;
  fits_badly_ = outside > 1.5 * outside_at_first_ + 0.01;
  constexpr int kFramesBetweenTries = 64;
  if (background_.first_alone) {
    background_.first_alone = 3 * use.odd_blocks < 2 * use.blocks;
    frames_without_first_ = 0;
  } else {
    background_.first_alone = ++frames_without_first_ % kFramesBetweenTries == 0;
  }
}

}  // namespace sslv
