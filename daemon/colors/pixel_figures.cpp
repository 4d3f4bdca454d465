// SPDX-License-Identifier: Apache-2.0
#include "colors/pixel_figures.h"

#include "vision/threshold.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace sslv {
namespace {

/// Begin and length, clipped to [0, size) and grown to multiples of `step`.
std::pair<int, int> within(int begin, int length, int size, int step) {
  const std::int64_t end = std::min<std::int64_t>(std::int64_t{begin} + length, size);
  const int from = std::max(begin, 0) / step * step;
  if (end <= from) return {0, 0};
  const int to = static_cast<int>((end + step - 1) / step) * step;
  return {from, std::min(to, size) - from};
}

}  // namespace

Yuv cell_color(const ImageView& image, int x, int y) {
  /// `luma` and `u`: offsets within the four bytes of two pixels.
  const auto yuv422 = [&](int luma, int u) {
    const std::uint8_t* pair = image.row(y) + static_cast<std::ptrdiff_t>(x / 2) * 4;
    return Yuv{pair[luma + x % 2 * 2], pair[u], pair[u + 2]};
  };
  const auto rgb = [&](int red) {
    const std::uint8_t* pixel = image.row(y) + static_cast<std::ptrdiff_t>(x) * 3;
    return to_yuv({pixel[red], pixel[1], pixel[2 - red]});
  };
  /// `red`: its index in the quad 0 1 / 2 3; blue is diagonally opposite.
  const auto bayer = [&](std::size_t red) {
    const std::uint8_t* upper = image.row(2 * y) + static_cast<std::ptrdiff_t>(x) * 2;
    const std::uint8_t* lower = image.row(2 * y + 1) + static_cast<std::ptrdiff_t>(x) * 2;
    const std::array<std::uint8_t, 4> quad{upper[0], upper[1], lower[0], lower[1]};
    const std::size_t green = red == 0 || red == 3 ? 1 : 0;
    const auto mean_green = static_cast<std::uint8_t>((quad[green] + quad[3 - green] + 1) / 2);
    return to_yuv({quad[red], mean_green, quad[3 - red]});
  };
  switch (image.format) {
    case PixelFormat::kUyvy: return yuv422(1, 0);
    case PixelFormat::kYuyv: return yuv422(0, 1);
    case PixelFormat::kRgb24: return rgb(0);
    case PixelFormat::kBgr24: return rgb(2);
    case PixelFormat::kMono8: return {image.row(y)[x], 128, 128};
    case PixelFormat::kBayerRg8: return bayer(0);
    case PixelFormat::kBayerGr8: return bayer(1);
    case PixelFormat::kBayerGb8: return bayer(2);
    case PixelFormat::kBayerBg8: return bayer(3);
  }
  return {0, 128, 128};
}

PixelBlock read_pixels(const ImageView& image, PixelBox box, const Lut& lut) {
  const int cell_px = is_bayer(image.format) ? 2 : 1;
  // In YUV 4:2:2 two pixels share their colour.
  const int step_x = is_yuv422(image.format) ? 2 : cell_px;
  PixelBlock out;
  out.cell_px = cell_px;
  const auto [x, width] = within(box.x, box.width, image.width, step_x);
  const auto [y, height] = within(box.y, box.height, image.height, cell_px);
  if (width == 0 || height == 0) return out;

  ImageView part = image;
  part.data = image.row(y) + static_cast<std::ptrdiff_t>(x) * bytes_per_pixel(image.format);
  part.width = width;
  part.height = height;
  LabelImage labels;
  Threshold().process({}, lut, Mask(), Image(part, nullptr, nullptr, nullptr), labels);

  // The requested columns, without the pixel that completes a pair.
  const int wished_x = std::max(box.x, 0) / cell_px * cell_px;
  const auto wished_end = std::min<std::int64_t>(std::int64_t{box.x} + box.width, x + width);
  const int skipped = (wished_x - x) / cell_px;
  out.columns = static_cast<int>((wished_end - wished_x + cell_px - 1) / cell_px);
  out.rows = height / cell_px;
  out.box = {wished_x, y, out.columns * cell_px, height};
  for (int row = 0; row < out.rows; ++row) {
    for (int column = skipped; column < skipped + out.columns; ++column) {
      out.colors.push_back(cell_color(part, column, row));
      out.labels.push_back(labels.row(row)[column]);
    }
  }
  return out;
}

std::vector<bool> region_around(const PixelBlock& block, int x_px, int y_px) {
  std::vector<bool> in_region(block.labels.size(), false);
  if (x_px < block.box.x || y_px < block.box.y) return in_region;
  const int column = (x_px - block.box.x) / block.cell_px, row = (y_px - block.box.y) / block.cell_px;
  if (column >= block.columns || row >= block.rows) return in_region;
  const auto at = [&](int c, int r) { return static_cast<std::size_t>(r * block.columns + c); };
  const Label label = block.labels[at(column, row)];
  std::vector<std::pair<int, int>> open{{column, row}};
  in_region[at(column, row)] = true;
  while (!open.empty()) {
    const auto [c, r] = open.back();
    open.pop_back();
    for (int next_r = std::max(r - 1, 0); next_r <= std::min(r + 1, block.rows - 1); ++next_r) {
      for (int next_c = std::max(c - 1, 0); next_c <= std::min(c + 1, block.columns - 1); ++next_c) {
        const std::size_t i = at(next_c, next_r);
        if (in_region[i] || block.labels[i] != label) continue;
        in_region[i] = true;
        open.emplace_back(next_c, next_r);
      }
    }
  }
  return in_region;
}

PixelFigures figures_of(const PixelBlock& block, const std::vector<bool>& chosen) {
  PixelFigures out;
  std::array<double, 3> sums{}, squares{};
  for (std::size_t i = 0; i < block.colors.size(); ++i) {
    if (!chosen.empty() && !chosen[i]) continue;
    ++out.count;
    ++out.cells[block.labels[i]];
    const std::array<std::uint8_t, 3> color{block.colors[i].y, block.colors[i].u, block.colors[i].v};
    for (std::size_t c = 0; c < 3; ++c) {
      sums[c] += color[c];
      squares[c] += static_cast<double>(color[c]) * color[c];
      ++out.histogram[c][color[c] * PixelFigures::kBins / 256];
    }
  }
  const auto n = static_cast<double>(std::max<std::size_t>(out.count, 1));
  for (std::size_t c = 0; c < 3; ++c) {
    out.mean[c] = sums[c] / n;
    out.spread[c] = std::sqrt(std::max(0.0, squares[c] / n - out.mean[c] * out.mean[c]));
  }
  return out;
}

}  // namespace sslv
