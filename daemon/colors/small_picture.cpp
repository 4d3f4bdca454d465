// SPDX-License-Identifier: Apache-2.0
#include "colors/small_picture.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace sslv {
namespace {

/// Channel sums of one row of cells: red, green and blue, or Y, U and V.
using RowSums = std::vector<std::array<std::int32_t, 3>>;

void add_rgb_row(const std::uint8_t* row, int cell_px, bool red_first, RowSums& cells) {
  const std::uint8_t* p = row;
  const std::size_t red = red_first ? 0 : 2;
  for (auto& cell : cells) {
    for (int i = 0; i < cell_px; ++i, p += 3) {
      cell[0] += p[red];
      cell[1] += p[1];
      cell[2] += p[2 - red];
    }
  }
}

void add_yuv_row(const std::uint8_t* row, int cell_px, bool luma_first, RowSums& cells) {
  const std::size_t luma = luma_first ? 0 : 1, chroma = 1 - luma;
  if (cell_px == 1) {
    for (std::size_t x = 0; x < cells.size(); ++x) {
      const std::uint8_t* pair = row + x / 2 * 4;
      cells[x][0] += pair[luma + x % 2 * 2];
      cells[x][1] += pair[chroma];
      cells[x][2] += pair[chroma + 2];
    }
    return;
  }
  const std::uint8_t* p = row;
  for (auto& cell : cells) {
    for (int i = 0; i < cell_px / 2; ++i, p += 4) {
      cell[0] += p[luma] + p[luma + 2];
      cell[1] += 2 * p[chroma];
      cell[2] += 2 * p[chroma + 2];
    }
  }
}

/// `even` and `odd`: colours (0 red, 1 green, 2 blue) of a row's even and odd pixels. Green has half the
/// weight, so that all colours weigh the same after two rows.
void add_bayer_row(const std::uint8_t* row, int cell_px, std::size_t even, std::size_t odd, RowSums& cells) {
  const std::uint8_t* p = row;
  const int even_weight = even == 1 ? 2 : 4, odd_weight = odd == 1 ? 2 : 4;
  for (auto& cell : cells) {
    for (int i = 0; i < cell_px / 2; ++i, p += 2) {
      cell[even] += even_weight * p[0];
      cell[odd] += odd_weight * p[1];
    }
  }
}

/// Positions of brightness samples. In Bayer images, only the samples of one colour count, so that neighbours
/// are comparable.
struct Grid {
  int first, step_px, step_bytes;
};
Grid brightness_grid(PixelFormat format) {
  if (is_bayer(format)) return {0, 2, 2};
  if (is_yuv422(format)) return {format == PixelFormat::kUyvy ? 1 : 0, 1, 2};
  return {1, 1, 3};
}

}  // namespace

bool has_colors(PixelFormat format) {
  return format != PixelFormat::kMono8;
}

SmallPicture::SmallPicture(const ImageView& image, int cell_px, const Mask* mask)
    : width_(image.width / cell_px), height_(image.height / cell_px), cell_px_(cell_px) {
  const auto stride = static_cast<std::size_t>(width_) + 1;
  sums_.resize(stride * (static_cast<std::size_t>(height_) + 1));
  RowSums cells(static_cast<std::size_t>(width_));
  const float scale = static_cast<float>(kScale) / static_cast<float>(cell_px * cell_px);
  for (int y = 0; y < height_; ++y) {
    std::fill(cells.begin(), cells.end(), std::array<std::int32_t, 3>{});
    for (int py = y * cell_px; py < (y + 1) * cell_px; ++py) {
      const std::uint8_t* row = image.row(py);
      if (is_yuv422(image.format)) {
        add_yuv_row(row, cell_px, image.format == PixelFormat::kYuyv, cells);
      } else if (is_bayer(image.format)) {
        const bool red_x = image.format == PixelFormat::kBayerGr8 || image.format == PixelFormat::kBayerBg8;
        const bool red_y = image.format == PixelFormat::kBayerGb8 || image.format == PixelFormat::kBayerBg8;
        const bool red_row = (py % 2 == 1) == red_y;
        const std::size_t other = red_row ? 0 : 2;
        const bool other_even = red_row != red_x;
        add_bayer_row(row, cell_px, other_even ? other : 1, other_even ? 1 : other, cells);
      } else {
        add_rgb_row(row, cell_px, image.format == PixelFormat::kRgb24, cells);
      }
    }
    const Sum* above = &sums_[static_cast<std::size_t>(y) * stride];
    Sum* out = &sums_[(static_cast<std::size_t>(y) + 1) * stride];
    Sum row_sum{};
    for (std::size_t x = 0; x < cells.size(); ++x) {
      float a = static_cast<float>(cells[x][0]) * scale, b = static_cast<float>(cells[x][1]) * scale,
            c = static_cast<float>(cells[x][2]) * scale;
      if (is_yuv422(image.format)) {
        const float u = b - 128 * kScale, v = c - 128 * kScale, luma = a;
        a = luma + 1.402F * v;
        b = luma - 0.344136F * u - 0.714136F * v;
        c = luma + 1.772F * u;
      }
      row_sum[0] += static_cast<std::uint32_t>(static_cast<std::int32_t>(std::floor(a + 0.5F)));
      row_sum[1] += static_cast<std::uint32_t>(static_cast<std::int32_t>(std::floor(b + 0.5F)));
      row_sum[2] += static_cast<std::uint32_t>(static_cast<std::int32_t>(std::floor(c + 0.5F)));
      for (std::size_t i = 0; i < 3; ++i) out[x + 1][i] = above[x + 1][i] + row_sum[i];
    }
  }
  if (mask == nullptr) return;
  shown_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 0);
  for (int y = 0; y < height_; ++y) {
    for (const Mask::Interval& part : mask->row(y * cell_px + cell_px / 2, 1)) {
      const int begin = (part.begin + cell_px - 1) / cell_px, end = std::min(part.end / cell_px, width_);
      for (int x = begin; x < end; ++x) shown_[index(x, y)] = 1;
    }
  }
}

std::array<std::int32_t, 3> SmallPicture::sum(int x, int y, int reach) const {
  const auto stride = static_cast<std::size_t>(width_) + 1;
  const auto at = [&](int column, int row) {
    return static_cast<std::size_t>(row) * stride + static_cast<std::size_t>(column);
  };
  const Sum &a = sums_[at(x - reach, y - reach)], &b = sums_[at(x + reach + 1, y - reach)],
            &c = sums_[at(x - reach, y + reach + 1)], &d = sums_[at(x + reach + 1, y + reach + 1)];
  std::array<std::int32_t, 3> out;
  for (std::size_t i = 0; i < 3; ++i) out[i] = static_cast<std::int32_t>(d[i] - b[i] - c[i] + a[i]);
  return out;
}

Color3 SmallPicture::at(int x, int y) const {
  return mean(x, y, 0);
}

Color3 SmallPicture::mean(int x, int y, int reach) const {
  const auto s = sum(x, y, reach);
  const double per = 1.0 / (kScale * (2 * reach + 1) * (2 * reach + 1));
  return {s[0] * per, s[1] * per, s[2] * per};
}

Color3 SmallPicture::ring_mean(int x, int y, int inner, int outer) const {
  const auto a = sum(x, y, outer), b = sum(x, y, inner);
  const int cells = (2 * outer + 1) * (2 * outer + 1) - (2 * inner + 1) * (2 * inner + 1);
  const double per = 1.0 / (kScale * cells);
  return {(a[0] - b[0]) * per, (a[1] - b[1]) * per, (a[2] - b[2]) * per};
}

double noise_of(const ImageView& image) {
  // Horizontal second difference of the vertical second difference: 0 on even areas and straight edges.
  const Grid grid = brightness_grid(image.format);
  const int step = grid.step_px;
  std::vector<int> sizes;
  constexpr int kAcross = 160, kDown = 120;
  const int every_x = std::max(1, (image.width / step - 2) / kAcross),
            every_y = std::max(1, (image.height / step - 2) / kDown);
  for (int y = step; y + step < image.height; y += every_y * step) {
    const std::uint8_t *above = image.row(y - step) + grid.first, *here = image.row(y) + grid.first,
                       *below = image.row(y + step) + grid.first;
    for (int i = 1; (i + 1) * step < image.width; i += every_x) {
      const int x = i * grid.step_bytes, s = grid.step_bytes;
      if (here[x] < 4 || here[x] > 250) continue;  // clipped, which hides the noise
      sizes.push_back(std::abs(4 * here[x] - 2 * (above[x] + below[x] + here[x - s] + here[x + s]) +
                               above[x - s] + above[x + s] + below[x - s] + below[x + s]));
    }
  }
  if (sizes.size() < 100) return 0;
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  // The median magnitude of a Gaussian is 0.6745 sigma; the squared weights sum to 36. Y mixes the noise of
  // three channels: its noise is 0.67 of one channel's noise.
  return *middle / 0.6745 / 6 / (is_yuv422(image.format) ? 0.67 : 1);
}

PictureExposure exposure_of(const SmallPicture& picture) {
  PictureExposure out;
  std::vector<double> brightness;
  std::size_t clipped = 0;
  double colorfulness = 0;
  const int step = std::max(1, std::min(picture.width(), picture.height()) / 150);
  for (int y = 0; y < picture.height(); y += step) {
    for (int x = 0; x < picture.width(); x += step) {
      if (!picture.shows(x, y)) continue;
      const Color3 color = picture.at(x, y);
      brightness.push_back(color.mean());
      colorfulness += color.maxCoeff() - color.minCoeff();
      if (color.maxCoeff() > 253) ++clipped;
    }
  }
  if (brightness.empty()) return out;
  out.clipped_share = static_cast<double>(clipped) / static_cast<double>(brightness.size());
  out.colorfulness = colorfulness / static_cast<double>(brightness.size());
  const auto at = brightness.begin() + static_cast<std::ptrdiff_t>(brightness.size() * 99 / 100);
  std::nth_element(brightness.begin(), at, brightness.end());
  out.bright = *at;
  return out;
}

}  // namespace sslv
