// SPDX-License-Identifier: Apache-2.0
#include "services/cameras/stills.h"

#include <gtest/gtest.h>

namespace sslv::stills_test {
namespace {

using namespace std::chrono_literals;

StillPicture picture_of(std::uint8_t gray, std::uint32_t frame) {
  // Rows have padding, as in drivers' buffers.
  const std::vector<std::uint8_t> bytes(5 * 8, gray);
  return {ImageView{bytes.data(), 6, 5, 8, PixelFormat::kMono8}, frame, 1.5};
}

TEST(Stills, KeepThePicturesBytes) {
  Stills stills;
  const int number = stills.keep(3, picture_of(77, 42));
  const auto still = stills.find(3, number);
  ASSERT_TRUE(still);
  EXPECT_EQ(still->frame_number, 42U);
  EXPECT_EQ(still->view.width, 6);
  EXPECT_EQ(still->bytes, std::vector<std::uint8_t>(30, 77));
  EXPECT_EQ(still->view.data, still->bytes.data());
  EXPECT_EQ(still->view.stride_bytes, 6);
  EXPECT_EQ(stills.find(3, number + 1), nullptr);
  EXPECT_EQ(stills.find(4, number), nullptr) << "another camera's";
}

TEST(Stills, OnlyTheNewestOfACameraStay) {
  Stills stills;
  const int other = stills.keep(1, picture_of(1, 1));
  std::vector<int> numbers;
  for (std::uint32_t i = 0; i <= Stills::kMaxOfACamera; ++i)
    numbers.push_back(stills.keep(0, picture_of(2, i)));
  EXPECT_EQ(stills.find(0, numbers.front()), nullptr);
  EXPECT_TRUE(stills.find(0, numbers[1]));
  EXPECT_TRUE(stills.find(0, numbers.back()));
  EXPECT_TRUE(stills.find(1, other));
}

TEST(Stills, GoWhenNobodyAsksForThem) {
  Stills stills;
  const auto start = Stills::Clock::now();
  const int asked = stills.keep(0, picture_of(1, 1), start), left = stills.keep(0, picture_of(2, 2), start);
  ASSERT_TRUE(stills.find(0, asked, start + Stills::kLongest - 1s));
  EXPECT_EQ(stills.find(0, left, start + Stills::kLongest + 1s), nullptr);
  EXPECT_TRUE(stills.find(0, asked, start + Stills::kLongest + 1s));
}

TEST(Stills, GoWithoutBeingAskedFor) {
  Stills stills;
  const auto start = Stills::Clock::now();
  const int number = stills.keep(0, picture_of(1, 1), start);
  const std::weak_ptr<const StillPicture> picture = stills.find(0, number, start);
  stills.forget_old(start + Stills::kLongest - 1s);
  EXPECT_FALSE(picture.expired());
  stills.forget_old(start + Stills::kLongest + 1s);
  EXPECT_TRUE(picture.expired()) << "its memory is given back";
}

}  // namespace
}  // namespace sslv::stills_test
