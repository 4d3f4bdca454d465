// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/buffer_pool.h"

#include <cstddef>
#include <cstdint>
#include <optional>

namespace sslv {

/// A BufferPool for images whose size is known only once they come.
class PicturePool {
 public:
  /// Allocates only when an image is larger than any before; low bits (`is_deep`) lie right behind it.
  /// Throws std::runtime_error when all buffers are out.
  Image take(PixelFormat format, int width, int height, std::uint8_t*& pixels, bool is_deep = false);
  /// One whose layout is not known yet: Image::narrow_to() says it.
  Image take(std::size_t bytes, std::uint8_t*& pixels);

 private:
  Image take(const ImageView& layout, std::size_t bytes, std::uint8_t*& pixels);

  std::optional<BufferPool> buffers_;
  std::size_t bytes_each_ = 0;
};

}  // namespace sslv
