// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"
#include "vision/mask.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include <Eigen/Core>

namespace sslv {

using Color3 = Eigen::Vector3d;  // red, green, blue in grey levels; unlike Rgb it may be below 0 or above 255

/// An image's colours, averaged over cells of cell_px x cell_px pixels, with fast sums over squares.
class SmallPicture {
 public:
  /// `cell_px` must be even for Bayer images, and 1 or even for YUV 4:2:2; the image must have colours. Cells
  /// whose middle the mask hides are not shown.
  SmallPicture(const ImageView& image, int cell_px, const Mask* mask);

  int width() const { return width_; }
  int height() const { return height_; }
  int cell_px() const { return cell_px_; }

  Color3 at(int x, int y) const;
  bool shows(int x, int y) const { return shown_.empty() || shown_[index(x, y)] != 0; }
  /// Mean over the square of 2 reach + 1 cells around a cell. The square must lie in the image.
  Color3 mean(int x, int y, int reach) const;
  /// Mean over the square of 2 outer + 1 cells without the square of 2 inner + 1 cells.
  Color3 ring_mean(int x, int y, int inner, int outer) const;

  /// Conversion between cell and pixel coordinates, in which centres are whole numbers.
  Eigen::Vector2d pixel_of(double x, double y) const {
    return {(x + 0.5) * cell_px_ - 0.5, (y + 0.5) * cell_px_ - 0.5};
  }
  Eigen::Vector2d cell_of(const Eigen::Vector2d& pixel) const {
    return {(pixel.x() + 0.5) / cell_px_ - 0.5, (pixel.y() + 0.5) / cell_px_ - 0.5};
  }

 private:
  /// Sums are in 1/16 grey level. They may overflow: their differences are still correct.
  static constexpr int kScale = 16;
  using Sum = std::array<std::uint32_t, 3>;
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }
  std::array<std::int32_t, 3> sum(int x, int y, int reach) const;

  int width_, height_, cell_px_;
  std::vector<Sum> sums_;  // sums of all cells above and to the left: (width + 1) x (height + 1)
  std::vector<std::uint8_t> shown_;
};

/// Caches an image's SmallPicture for each cell size requested.
class SmallPictures {
 public:
  SmallPictures(const ImageView& image, const Mask* mask) : image_(image), mask_(mask) {}
  const SmallPicture& of(int cell_px) {
    const auto at = pictures_.find(cell_px);
    return at != pictures_.end() ? at->second
                                 : pictures_.try_emplace(cell_px, image_, cell_px, mask_).first->second;
  }
  /// The finest cells that contain all three colours.
  const SmallPicture& finest() { return of(is_bayer(image_.format) || is_yuv422(image_.format) ? 2 : 1); }

 private:
  ImageView image_;
  const Mask* mask_;
  std::map<int, SmallPicture> pictures_;
};

/// Whether colours can be learnt from images of this format.
bool has_colors(PixelFormat format);

/// Noise of one pixel in grey levels: a robust estimate from differences of neighbouring brightness values. 0
/// if there are too few values.
double noise_of(const ImageView& image);

/// Share of clipped cells, and the brightness that 1 % of the cells exceed; from a grid of the cells that the
/// mask shows.
struct PictureExposure {
  double clipped_share = 0, bright = 0;
  double colorfulness = 0;  // mean range of red, green and blue
};
PictureExposure exposure_of(const SmallPicture& picture);

}  // namespace sslv
