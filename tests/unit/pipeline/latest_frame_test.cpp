// SPDX-License-Identifier: Apache-2.0
#include "pipeline/latest_frame.h"

#include "support/patience.h"

#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace sslv::latest_frame_test {
namespace {

using namespace std::chrono_literals;
using test::kPatience;

class LatestFrameTest : public testing::Test {
 protected:
  /// Puts a new frame with this number.
  void put(std::uint32_t number) {
    FrameRef frame = ring_.acquire();
    ASSERT_TRUE(frame);
    frame->info.number = number;
    latest_.put(std::move(frame));
  }
  std::size_t held() { return ring_.give_back(); }

  FrameRing ring_{4};
  LatestFrame latest_{ring_};
};

TEST_F(LatestFrameTest, IsEmptyBeforeTheFirstPut) {
  EXPECT_FALSE(latest_.peek().has_value());
  EXPECT_FALSE(latest_.wait_newer(0, 0ms).has_value());
}

TEST_F(LatestFrameTest, ANewerFrameReplacesAnUnreadOne) {
  put(1);
  put(2);
  const auto seen = latest_.wait_newer(0, 0ms);
  ASSERT_TRUE(seen.has_value());
  EXPECT_EQ(seen->value->info.number, 2U);
  EXPECT_EQ(seen->version, 2U);
  EXPECT_FALSE(latest_.wait_newer(seen->version, 0ms).has_value()) << "nothing newer";
}

TEST_F(LatestFrameTest, SeveralReadersSeeTheSameFrame) {
  put(7);
  EXPECT_EQ(latest_.wait_newer(0, 0ms)->value->info.number, 7U);
  EXPECT_EQ(latest_.wait_newer(0, 0ms)->value->info.number, 7U);
  EXPECT_EQ(latest_.peek()->value->info.number, 7U);
}

TEST_F(LatestFrameTest, LetsGoOfAReplacedFrame) {
  for (std::uint32_t i = 0; i < 10; ++i) {
    put(i);
    EXPECT_EQ(held(), 1U);
  }
  const FrameRef looked_at = latest_.peek()->value;
  put(10);
  EXPECT_EQ(held(), 2U);
  EXPECT_EQ(looked_at->info.number, 9U);
}

TEST_F(LatestFrameTest, CloseLetsGoOfTheFrameAndOfLaterOnes) {
  put(1);
  latest_.close();
  EXPECT_EQ(held(), 0U);
  put(2);
  EXPECT_EQ(held(), 0U);
  EXPECT_FALSE(latest_.peek().has_value());
  EXPECT_FALSE(latest_.wait_newer(0, kPatience).has_value()) << "returns at once";
  latest_.close();
}

TEST_F(LatestFrameTest, CloseWakesAWaitingReader) {
  put(1);
  std::thread reader([&] { EXPECT_FALSE(latest_.wait_newer(1, kPatience).has_value()); });
  latest_.close();
  reader.join();
}

TEST_F(LatestFrameTest, AWaitingReaderGetsTheNextFrame) {
  std::thread reader([&] { EXPECT_EQ(latest_.wait_newer(0, kPatience)->value->info.number, 5U); });
  put(5);
  reader.join();
}

TEST_F(LatestFrameTest, ReadersSeeRisingVersionsAndTheLastFrame) {
  constexpr std::uint32_t kLast = 5000;
  std::vector<std::thread> readers;
  for (int r = 0; r < 2; ++r) {
    readers.emplace_back([&] {
      std::uint64_t version = 0;
      std::uint32_t number = 0;
      while (number < kLast) {
        const auto seen = latest_.wait_newer(version, kPatience);
        ASSERT_TRUE(seen.has_value());
        ASSERT_GT(seen->version, version);
        ASSERT_GT(seen->value->info.number, number);
        version = seen->version;
        number = seen->value->info.number;
      }
    });
  }
  for (std::uint32_t i = 1; i <= kLast; ++i) put(i);
  for (auto& reader : readers) reader.join();
  EXPECT_EQ(held(), 1U);
}

}  // namespace
}  // namespace sslv::latest_frame_test
