// SPDX-License-Identifier: Apache-2.0
#include "capture/buffer_pool.h"

#include "image/shared_memory.h"

#include <gtest/gtest.h>

namespace sslv::buffer_pool_test {
namespace {

TEST(BufferPool, LendsEachBufferOnceAtATime) {
  const ImageView layout{nullptr, 4, 2, 4, PixelFormat::kMono8};
  BufferPool pool(2, 8);
  std::uint8_t *first = nullptr, *second = nullptr, *none = nullptr;
  Image a = pool.take(layout, first);
  const Image b = pool.take(layout, second);
  EXPECT_NE(first, second);
  EXPECT_EQ(a.view().data, first);
  EXPECT_EQ(a.view().width, 4);
  EXPECT_TRUE(pool.take(layout, none).view().empty());
  EXPECT_EQ(none, nullptr);
  a = Image();
  std::uint8_t* again = nullptr;
  const Image c = pool.take(layout, again);
  EXPECT_EQ(again, first);
}

TEST(BufferPool, PicturesOutliveIt) {
  Image image;
  {
    BufferPool pool(1, 8);
    std::uint8_t* bytes = nullptr;
    image = pool.take({nullptr, 4, 2, 4, PixelFormat::kMono8}, bytes);
    bytes[7] = 42;
  }
  EXPECT_EQ(image.view().data[7], 42);
}

TEST(BufferPool, UsesSharedMemoryOnRequest) {
  const ImageView layout{nullptr, 4, 2, 4, PixelFormat::kMono8};
  std::uint8_t* bytes = nullptr;
  BufferPool own(1, 8);
  const Image plain = own.take(layout, bytes);
  EXPECT_FALSE(shared_place(bytes, 8));
  share_new_images(true);
  Image image;
  {
    BufferPool pool(2, 8);
    share_new_images(false);
    image = pool.take(layout, bytes);
    std::uint8_t* second = nullptr;
    const Image other = pool.take(layout, second);
    ASSERT_TRUE(shared_place(bytes, 8));
    EXPECT_EQ(shared_place(bytes, 8)->id, shared_place(second, 8)->id);
    EXPECT_GE(second - bytes, 4096);
  }
  EXPECT_TRUE(shared_place(bytes, 8)) << "images outlive it";
  image = Image();
  EXPECT_FALSE(shared_place(bytes, 8));
}

}  // namespace
}  // namespace sslv::buffer_pool_test
