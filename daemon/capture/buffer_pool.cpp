// SPDX-License-Identifier: Apache-2.0
#include "capture/buffer_pool.h"

#include "image/shared_memory.h"

#include <atomic>
#include <optional>
#include <system_error>
#include <utility>

namespace sslv {

struct BufferPool::Buffer {
  std::uint8_t* bytes = nullptr;
  std::atomic<bool> free{true};
  std::shared_ptr<Buffers> keeps;  // keeps the pool's memory alive while lent
};

struct BufferPool::Buffers {
  std::vector<std::unique_ptr<Buffer>> all;
  // The images are stored either in `own` or in `shared`. Buffers that are never lent take no physical
  // memory.
  std::vector<std::unique_ptr<std::uint8_t[]>> own;
  std::optional<SharedMemory> shared;
};

BufferPool::BufferPool(std::size_t buffers, std::size_t bytes_each) : buffers_(std::make_shared<Buffers>()) {
  constexpr std::size_t kPage = 4096;  // no two buffers share a page
  const std::size_t step = (bytes_each + kPage - 1) / kPage * kPage;
  if (new_images_are_shared() && buffers * step > 0) {
    try {
      buffers_->shared.emplace(buffers * step);
    } catch (const std::system_error&) {  // images are then copied for other processes
    }
  }
  for (std::size_t i = 0; i < buffers; ++i) {
    buffers_->all.push_back(std::make_unique<Buffer>());
    std::uint8_t*& bytes = buffers_->all.back()->bytes;
    if (buffers_->shared) {
      bytes = buffers_->shared->data() + i * step;
    } else {
      buffers_->own.push_back(std::make_unique_for_overwrite<std::uint8_t[]>(bytes_each));
      bytes = buffers_->own.back().get();
    }
  }
}

Image BufferPool::take(const ImageView& layout, std::uint8_t*& bytes) noexcept {
  for (const auto& buffer : buffers_->all) {
    if (!buffer->free.load(std::memory_order_acquire)) continue;
    buffer->free.store(false, std::memory_order_relaxed);
    buffer->keeps = buffers_;
    bytes = buffer->bytes;
    ImageView view = layout;
    view.data = bytes;
    return {view, nullptr, buffer.get(), &give_back};
  }
  return {};
}

void BufferPool::give_back(void* /*owner*/, void* buffer) noexcept {
  auto* returned = static_cast<Buffer*>(buffer);
  // Keeps the pool, which owns the buffer, alive until after the last access to the buffer.
  const std::shared_ptr<Buffers> keeps = std::move(returned->keeps);
  returned->free.store(true, std::memory_order_release);
}

}  // namespace sslv
