// SPDX-License-Identifier: Apache-2.0
#include "image/image.h"

#include <type_traits>
#include <vector>

#include <gmock/gmock.h>

namespace sslv::image_test {
namespace {

static_assert(!std::is_copy_constructible_v<Image> && !std::is_copy_assignable_v<Image>);
static_assert(std::is_nothrow_move_constructible_v<Image> && std::is_nothrow_move_assignable_v<Image>);

/// A fake driver that records returned buffers.
struct Driver {
  std::vector<int> returned;
  std::vector<std::uint8_t> pixels = std::vector<std::uint8_t>(8);

  Image lend(int& buffer) {
    return {
        {pixels.data(), 4, 2, 4, PixelFormat::kMono8}, this, &buffer, [](void* owner, void* lent) noexcept {
          static_cast<Driver*>(owner)->returned.push_back(*static_cast<int*>(lent));
        }};
  }
};

class ImageLease : public testing::Test {
 protected:
  Driver driver_;
  int first_ = 1, second_ = 2;
};

TEST_F(ImageLease, GivesTheBufferBackOnce) {
  {
    const Image image = driver_.lend(first_);
    EXPECT_EQ(image.view().data, driver_.pixels.data());
    EXPECT_TRUE(driver_.returned.empty());
  }
  EXPECT_THAT(driver_.returned, testing::ElementsAre(1));
}

TEST_F(ImageLease, MovesWithTheImage) {
  {
    Image from = driver_.lend(first_);
    const Image to = std::move(from);
    EXPECT_TRUE(from.view().empty());  // NOLINT(bugprone-use-after-move): a moved-from image is empty
    EXPECT_FALSE(to.view().empty());
    from = Image();
    EXPECT_TRUE(driver_.returned.empty());
  }
  EXPECT_THAT(driver_.returned, testing::ElementsAre(1));
}

TEST_F(ImageLease, AssignmentGivesTheOldBufferBackAtOnce) {
  Image image = driver_.lend(first_);
  Image other = driver_.lend(second_);
  image = std::move(other);
  EXPECT_THAT(driver_.returned, testing::ElementsAre(1));
  image = Image();
  EXPECT_THAT(driver_.returned, testing::ElementsAre(1, 2));
  EXPECT_TRUE(image.view().empty());
}

TEST(PixelFormat, NamesAreReadBack) {
  for (int i = 0; i <= static_cast<int>(PixelFormat::kBayerBg8); ++i) {
    const auto format = static_cast<PixelFormat>(i);
    EXPECT_EQ(pixel_format_named(name_of(format)), format) << name_of(format);
  }
  EXPECT_EQ(name_of(PixelFormat::kBayerGr8), "bayer_gr8");
  EXPECT_FALSE(pixel_format_named("RGB24").has_value());
  EXPECT_FALSE(pixel_format_named("unknown").has_value());
}

TEST(PixelFormat, BytesOfAPixel) {
  EXPECT_EQ(bytes_per_pixel(PixelFormat::kUyvy), 2);
  EXPECT_EQ(bytes_per_pixel(PixelFormat::kYuyv), 2);
  EXPECT_EQ(bytes_per_pixel(PixelFormat::kRgb24), 3);
  EXPECT_EQ(bytes_per_pixel(PixelFormat::kBgr24), 3);
  EXPECT_EQ(bytes_per_pixel(PixelFormat::kMono8), 1);
  EXPECT_EQ(bytes_per_pixel(PixelFormat::kBayerRg8), 1);
}

TEST(PixelFormat, SizesSuitTheLayout) {
  EXPECT_TRUE(is_valid_size(PixelFormat::kMono8, 3, 3));
  EXPECT_TRUE(is_valid_size(PixelFormat::kUyvy, 4, 3));
  EXPECT_FALSE(is_valid_size(PixelFormat::kUyvy, 3, 4)) << "half a pair";
  EXPECT_TRUE(is_valid_size(PixelFormat::kBayerRg8, 4, 4));
  EXPECT_FALSE(is_valid_size(PixelFormat::kBayerRg8, 4, 3)) << "half a quad";
  EXPECT_FALSE(is_valid_size(PixelFormat::kBayerRg8, 3, 4));
  EXPECT_FALSE(is_valid_size(PixelFormat::kMono8, 1, 2));
  EXPECT_FALSE(is_valid_size(PixelFormat::kMono8, 2, 0));
  EXPECT_FALSE(is_valid_size(PixelFormat::kMono8, -2, -2));
  EXPECT_TRUE(is_valid_size(PixelFormat::kMono8, 16384, 16384));
  EXPECT_FALSE(is_valid_size(PixelFormat::kMono8, 16385, 2));
}

}  // namespace
}  // namespace sslv::image_test
