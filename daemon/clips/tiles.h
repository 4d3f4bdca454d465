// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

namespace sslv {

/// A part of an image that is kept as a whole: its pixels, right and bottom one past the last.
struct Tile {
  int left = 0, top = 0, right = 0, bottom = 0;
};

constexpr int tiles_across(int px, int tile_px) {
  return (px + tile_px - 1) / tile_px;
}
/// Of the bits that say which tiles are marked.
constexpr std::size_t tile_bits_bytes(int width, int height, int tile_px) {
  return (static_cast<std::size_t>(tiles_across(width, tile_px)) *
              static_cast<std::size_t>(tiles_across(height, tile_px)) +
          7) /
         8;
}

/// use(tile) for each one that is marked in `bits`, row by row; those without a bit are not. Tiles at the
/// right and lower edge are cut off there.
template <class Use>
void each_tile(int width, int height, int tile_px, std::span<const std::byte> bits, const Use& use) {
  const int columns = tiles_across(width, tile_px), rows = tiles_across(height, tile_px);
  std::size_t at = 0;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column, ++at) {
      if (at / 8 >= bits.size() || (bits[at / 8] >> (at % 8) & std::byte{1}) == std::byte{0}) continue;
      const int left = column * tile_px, top = row * tile_px;
      use(Tile{left, top, std::min(left + tile_px, width), std::min(top + tile_px, height)});
    }
  }
}

inline std::size_t pixels_in_tiles(int width, int height, int tile_px, std::span<const std::byte> bits) {
  std::size_t pixels = 0;
  each_tile(width, height, tile_px, bits, [&](const Tile& tile) {
    pixels +=
        static_cast<std::size_t>(tile.right - tile.left) * static_cast<std::size_t>(tile.bottom - tile.top);
  });
  return pixels;
}

}  // namespace sslv
