// SPDX-License-Identifier: Apache-2.0
#include "capture/files/picture_pool.h"

#include <stdexcept>

namespace sslv {

Image PicturePool::take(PixelFormat format, int width, int height, std::uint8_t*& pixels, bool is_deep) {
  ImageView layout{nullptr, width, height, std::ptrdiff_t{width} * bytes_per_pixel(format), format};
  const std::ptrdiff_t plane_bytes = layout.stride_bytes * height;
  if (is_deep) layout.to_low_bits = plane_bytes;
  return take(layout, static_cast<std::size_t>(plane_bytes + layout.to_low_bits), pixels);
}

Image PicturePool::take(std::size_t bytes, std::uint8_t*& pixels) {
  return take(ImageView{}, bytes, pixels);
}

Image PicturePool::take(const ImageView& layout, std::size_t bytes, std::uint8_t*& pixels) {
  constexpr std::size_t kBuffers = 12;  // slightly more than the frames that the daemon keeps per camera
  constexpr std::size_t kSpare = 64;    // swscale's vector code may write slightly past the end
  bytes += kSpare;
  if (bytes > bytes_each_) {
    buffers_.emplace(kBuffers, bytes);
    bytes_each_ = bytes;
  }
  Image image = buffers_->take(layout, pixels);
  if (image.view().empty()) throw std::runtime_error("all buffers are still in use");
  return image;
}

}  // namespace sslv
