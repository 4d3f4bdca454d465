// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/buffer_pool.h"

#include <cstddef>
#include <cstdint>
#include <optional>

namespace sslv {

/// A BufferPool for images whose size is unknown until they arrive.
class PicturePool {
 public:
  /// Allocates memory only if the image is larger than all images before. With `is_deep`, low bits follow the
  /// image directly. Throws std::runtime_error if all buffers are lent.
  Image take(PixelFormat format, int width, int height, std::uint8_t*& pixels, bool is_deep = false);
  /// For an image whose layout is not known yet; set it with Image::narrow_to().
  Image take(std::size_t bytes, std::uint8_t*& pixels);

 private:
  Image take(const ImageView& layout, std::size_t bytes, std::uint8_t*& pixels);

  std::optional<BufferPool> buffers_;
  std::size_t bytes_each_ = 0;
};

}  // namespace sslv
