// SPDX-License-Identifier: Apache-2.0
#include "three_passes.h"

#include <algorithm>

namespace sslv::bench {
namespace {

constexpr Label kEndOfRow = 255;

std::size_t yuv_index(unsigned y, unsigned u, unsigned v) {
  return (y >> 4) << 12 | (u >> 2) << 6 | v >> 2;
}
std::size_t rgb_index(unsigned r, unsigned g, unsigned b) {
  return (r >> 3) << 11 | (g >> 2) << 5 | b >> 3;
}

}  // namespace

ThreePasses::ThreePasses(const Lut& lut) : yuv_(65'536), rgb_(65'536) {
  const auto byte = [](unsigned value) { return static_cast<std::uint8_t>(value); };
  for (unsigned y = 8; y < 256; y += 16) {
    for (unsigned u = 2; u < 256; u += 4) {
      for (unsigned v = 2; v < 256; v += 4) yuv_[yuv_index(y, u, v)] = lut.of_yuv(byte(y), byte(u), byte(v));
    }
  }
  for (unsigned r = 4; r < 256; r += 8) {
    for (unsigned g = 2; g < 256; g += 4) {
      for (unsigned b = 4; b < 256; b += 8) rgb_[rgb_index(r, g, b)] = lut.of_rgb(byte(r), byte(g), byte(b));
    }
  }
}

const std::vector<ThreePasses::Region>& ThreePasses::process(const ImageView& image) {
  threshold(image);
  find_runs();
  connect();
  extract();
  sort();
  return regions_;
}

void ThreePasses::threshold(const ImageView& image) {
  const int cell_px = is_bayer(image.format) ? 2 : 1;
  width_ = image.width / cell_px;
  height_ = image.height / cell_px;
  const auto stride = static_cast<std::size_t>(width_) + 1;
  map_.resize(stride * static_cast<std::size_t>(height_));
  const Label* yuv = yuv_.data();
  const Label* rgb = rgb_.data();
  for (int y = 0; y < height_; ++y) {
    const std::uint8_t* in = image.row(y * cell_px);
    const std::uint8_t* lower = in + image.stride_bytes;
    Label* out = map_.data() + static_cast<std::size_t>(y) * stride;
    out[width_] = kEndOfRow;
    switch (image.format) {
      case PixelFormat::kUyvy:
        for (int x = 0; x < width_; x += 2, in += 4) {
          out[x] = yuv[yuv_index(in[1], in[0], in[2])];
          out[x + 1] = yuv[yuv_index(in[3], in[0], in[2])];
        }
        break;
      case PixelFormat::kRgb24:
        for (int x = 0; x < width_; ++x, in += 3) out[x] = rgb[rgb_index(in[0], in[1], in[2])];
        break;
      case PixelFormat::kBayerRg8:
        for (int x = 0; x < width_; ++x, in += 2, lower += 2) {
          out[x] = rgb[rgb_index(in[0], (in[1] + lower[0] + 1U) / 2, lower[1])];
        }
        break;
      default: break;  // not measured
    }
  }
}

void ThreePasses::find_runs() {
  runs_.clear();
  const auto stride = static_cast<std::size_t>(width_) + 1;
  for (int y = 0; y < height_; ++y) {
    const Label* row = map_.data() + static_cast<std::size_t>(y) * stride;
    for (int x = 0; x < width_;) {
      const Label label = row[x];
      const int begin = x;
      while (row[x] == label) ++x;
      if (label == 0) continue;
      runs_.push_back({static_cast<std::int16_t>(begin), static_cast<std::int16_t>(y),
                       static_cast<std::int16_t>(x - begin), label, static_cast<std::int32_t>(runs_.size())});
    }
  }
}

void ThreePasses::connect() {
  const auto root_of = [this](std::int32_t i) {
    while (runs_[static_cast<std::size_t>(i)].parent != i) i = runs_[static_cast<std::size_t>(i)].parent;
    return i;
  };
  std::size_t above = 0;
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    Run& run = runs_[i];
    while (runs_[above].y < run.y - 1) ++above;
    while (runs_[above].y == run.y - 1 && runs_[above].x + runs_[above].width <= run.x) ++above;
    for (std::size_t j = above; runs_[j].y == run.y - 1 && runs_[j].x < run.x + run.width; ++j) {
      if (runs_[j].label != run.label) continue;
      const std::int32_t a = root_of(runs_[j].parent), b = root_of(run.parent);
      runs_[static_cast<std::size_t>(std::max(a, b))].parent = std::min(a, b);
      run.parent = std::min(a, b);
    }
  }
  // Every parent precedes its child, so one more pass points all runs at their roots.
  for (Run& run : runs_) run.parent = runs_[static_cast<std::size_t>(run.parent)].parent;
}

void ThreePasses::extract() {
  regions_.clear();
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    Run& run = runs_[i];
    const auto right = static_cast<std::int16_t>(run.x + run.width - 1);
    const std::int64_t sum_x = std::int64_t{run.x + right} * run.width;
    const std::int64_t sum_y = std::int64_t{run.y} * run.width;
    if (run.parent == static_cast<std::int32_t>(i)) {
      run.parent = static_cast<std::int32_t>(regions_.size());  // from here on: the region's index
      regions_.push_back({run.label, run.width, run.x, run.y, right, run.y, sum_x, sum_y, 0, 0});
      continue;
    }
    run.parent = runs_[static_cast<std::size_t>(run.parent)].parent;
    Region& region = regions_[static_cast<std::size_t>(run.parent)];
    region.area += run.width;
    region.left = std::min(region.left, run.x);
    region.right = std::max(region.right, right);
    region.bottom = run.y;
    region.sum_x += sum_x;
    region.sum_y += sum_y;
  }
  for (Region& region : regions_) {
    region.x = static_cast<float>(region.sum_x) * 0.5f / static_cast<float>(region.area);
    region.y = static_cast<float>(region.sum_y) / static_cast<float>(region.area);
  }
}

void ThreePasses::sort() {
  std::sort(regions_.begin(), regions_.end(), [](const Region& a, const Region& b) {
    return a.label != b.label ? a.label < b.label : a.area > b.area;
  });
}

}  // namespace sslv::bench
