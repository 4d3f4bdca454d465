// SPDX-License-Identifier: Apache-2.0
#include "capture/buffer_pool.h"

#include <gtest/gtest.h>

namespace sslv {
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

}  // namespace
}  // namespace sslv
