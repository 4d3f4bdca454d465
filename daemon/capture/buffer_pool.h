// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace sslv {

/// Image buffers for backends that fill their own. A buffer is lent out as an Image and is free again when
/// that is let go, in whatever thread; Images may outlive the pool. The buffers lie in memory that other
/// processes may look at where that is wanted (share_new_images()).
class BufferPool {
 public:
  BufferPool(std::size_t buffers, std::size_t bytes_each);

  /// Lends a free buffer with the layout's size, stride and format; `bytes` is where to write it. An empty
  /// Image when all are out. One thread only; allocates nothing.
  Image take(const ImageView& layout, std::uint8_t*& bytes) noexcept;

 private:
  struct Buffer;
  struct Buffers;
  static void give_back(void* owner, void* buffer) noexcept;

  std::shared_ptr<Buffers> buffers_;
};

}  // namespace sslv
