// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace sslv {

/// Image buffers for backends that fill their own buffers. take() lends a buffer as an Image; releasing the
/// Image, on any thread, frees the buffer. Images may outlive the pool. The buffers are in shared memory if
/// share_new_images() enabled it, so that other processes can read them.
class BufferPool {
 public:
  BufferPool(std::size_t buffers, std::size_t bytes_each);

  /// Lends a free buffer with the layout's size, stride and format; `bytes` receives the address at which to
  /// write the image. Returns an empty Image if all buffers are lent. For one thread; allocates nothing.
  Image take(const ImageView& layout, std::uint8_t*& bytes) noexcept;

 private:
  struct Buffer;
  struct Buffers;
  static void give_back(void* owner, void* buffer) noexcept;

  std::shared_ptr<Buffers> buffers_;
};

}  // namespace sslv
