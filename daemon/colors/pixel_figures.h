// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/color.h"
#include "image/image.h"
#include "vision/label.h"
#include "vision/lut.h"

#include <array>
#include <cstddef>
#include <vector>

namespace sslv {

/// A rectangle of an image, in pixels.
struct PixelBox {
  int x = 0, y = 0, width = 0, height = 0;
};

/// The cells of a rectangle, row by row: pixels, or the 2x2 quads of a Bayer image, with the labels that a
/// table assigns to them.
struct PixelBlock {
  PixelBox box;  // the rectangle clipped to the image and grown to whole cells
  int cell_px = 1;
  int columns = 0, rows = 0;
  std::vector<Yuv> colors;
  std::vector<Label> labels;
};

/// The colour of the cell at (x, y), in cell coordinates: a pixel, or a 2x2 quad of a Bayer image.
Yuv cell_color(const ImageView& image, int x, int y);

/// The cells of a rectangle; empty if the rectangle lies outside the image. Grey pixels have U = V = 128.
PixelBlock read_pixels(const ImageView& image, PixelBox box, const Lut& lut);

/// Flags the cells that have the same label as the cell of this pixel and are connected to it (8 neighbours).
/// Flags no cell if the pixel lies outside the block.
std::vector<bool> region_around(const PixelBlock& block, int x_px, int y_px);

/// Statistics of some cells.
struct PixelFigures {
  static constexpr std::size_t kBins = 64;
  std::size_t count = 0;
  std::array<double, 3> mean{}, spread{};             // mean and standard deviation of Y, U, V
  std::array<std::size_t, label::kMaxCount> cells{};  // count of each label
  std::array<std::array<std::size_t, kBins>, 3> histogram{};
};

/// `chosen`: one flag for each cell of the block; empty: all.
PixelFigures figures_of(const PixelBlock& block, const std::vector<bool>& chosen = {});

}  // namespace sslv
