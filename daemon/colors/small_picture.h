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

using Color3 = Eigen::Vector3d;  // red, green, blue in grey levels; unlike Rgb it may lie outside the cube

/// An image's colours, averaged over cells of cell_px x cell_px pixels, with sums over rectangles at hand.
class SmallPicture {
 public:
  /// `cell_px` is even for Bayer images, and 1 or even for YUV 4:2:2. The image has colours. Cells whose
  /// middle the mask hides are not shown.
  SmallPicture(const ImageView& image, int cell_px, const Mask* mask);

  int width() const { return width_; }
  int height() const { return height_; }
  int cell_px() const { return cell_px_; }

  Color3 at(int x, int y) const;
  bool shows(int x, int y) const { return shown_.empty() || shown_[index(x, y)] != 0; }
  /// Mean over the square of 2 reach + 1 cells about a cell, which must lie in the image.
  Color3 mean(int x, int y, int reach) const;
  /// Mean over the square of 2 outer + 1 cells without that of 2 inner + 1.
  Color3 ring_mean(int x, int y, int inner, int outer) const;

  /// Between cells and pixels, whose centres are whole numbers.
  Eigen::Vector2d pixel_of(double x, double y) const {
    return {(x + 0.5) * cell_px_ - 0.5, (y + 0.5) * cell_px_ - 0.5};
  }
  Eigen::Vector2d cell_of(const Eigen::Vector2d& pixel) const {
    return {(pixel.x() + 0.5) / cell_px_ - 0.5, (pixel.y() + 0.5) / cell_px_ - 0.5};
  }

 private:
  /// Sums are whole numbers of 1/16 grey level. They may overflow: differences of them come out right.
  static constexpr int kScale = 16;
  using Sum = std::array<std::uint32_t, 3>;
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }
  std::array<std::int32_t, 3> sum(int x, int y, int reach) const;

  int width_, height_, cell_px_;
  std::vector<Sum> sums_;  // of all cells above and to the left: (width + 1) x (height + 1)
  std::vector<std::uint8_t> shown_;
};

/// An image in cells of the sizes that were asked for, each made once.
class SmallPictures {
 public:
  SmallPictures(const ImageView& image, const Mask* mask) : image_(image), mask_(mask) {}
  const SmallPicture& of(int cell_px) {
    const auto at = pictures_.find(cell_px);
    return at != pictures_.end() ? at->second
                                 : pictures_.try_emplace(cell_px, image_, cell_px, mask_).first->second;
  }
  /// The finest cells that each know all three colours.
  const SmallPicture& finest() { return of(is_bayer(image_.format) || is_yuv422(image_.format) ? 2 : 1); }

 private:
  ImageView image_;
  const Mask* mask_;
  std::map<int, SmallPicture> pictures_;
};

/// Whether learning can look at such an image at all.
bool has_colors(PixelFormat format);

/// Noise of one pixel in grey levels, from how neighbours differ: a robust estimate on the image's
/// brightness. 0 for none.
double noise_of(const ImageView& image);

/// Share of the pixels with a channel at its end, and the brightness that 1 % of the pixels exceed; from a
/// grid of pixels that the mask shows.
struct PictureExposure {
  double clipped_share = 0, bright = 0;
  double colorfulness = 0;  // mean difference of the largest from the smallest of red, green and blue
};
PictureExposure exposure_of(const SmallPicture& picture);

}  // namespace sslv
