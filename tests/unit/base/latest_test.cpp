// SPDX-License-Identifier: Apache-2.0
#include "base/latest.h"

#include <memory>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace sslv {
namespace {

using namespace std::chrono_literals;
constexpr auto kLong = 10s;  // no test that passes waits for it

TEST(Latest, IsEmptyBeforeTheFirstPut) {
  const Latest<int> latest;
  EXPECT_FALSE(latest.peek().has_value());
  EXPECT_FALSE(latest.wait_newer(0, 0ms).has_value());
}

TEST(Latest, ANewerValueReplacesAnUnreadOne) {
  Latest<int> latest;
  latest.put(1);
  latest.put(2);
  const auto seen = latest.wait_newer(0, 0ms);
  ASSERT_TRUE(seen.has_value());
  EXPECT_EQ(seen->value, 2);
  EXPECT_EQ(seen->version, 2U);
  EXPECT_FALSE(latest.wait_newer(seen->version, 0ms).has_value()) << "nothing newer";
}

TEST(Latest, SeveralReadersSeeTheSameValue) {
  Latest<int> latest;
  latest.put(7);
  EXPECT_EQ(latest.wait_newer(0, 0ms)->value, 7);
  EXPECT_EQ(latest.wait_newer(0, 0ms)->value, 7);
  EXPECT_EQ(latest.peek()->value, 7);
}

TEST(Latest, LetsGoOfAReplacedValue) {
  Latest<std::shared_ptr<int>> latest;
  auto value = std::make_shared<int>(1);
  const std::weak_ptr<int> old = value;
  latest.put(std::move(value));
  EXPECT_FALSE(old.expired());
  latest.put(nullptr);
  EXPECT_TRUE(old.expired());
}

TEST(Latest, CloseLetsGoOfTheValueAndOfLaterOnes) {
  Latest<std::shared_ptr<int>> latest;
  auto value = std::make_shared<int>(1);
  latest.put(value);
  latest.close();
  EXPECT_EQ(value.use_count(), 1);
  latest.put(value);
  EXPECT_EQ(value.use_count(), 1);
  EXPECT_FALSE(latest.peek().has_value());
  EXPECT_FALSE(latest.wait_newer(0, kLong).has_value()) << "returns at once";
}

TEST(Latest, CloseWakesAWaitingReader) {
  Latest<int> latest;
  latest.put(1);
  std::thread reader([&] { EXPECT_FALSE(latest.wait_newer(1, kLong).has_value()); });
  latest.close();
  reader.join();
}

TEST(Latest, AWaitingReaderGetsTheNextValue) {
  Latest<int> latest;
  std::thread reader([&] { EXPECT_EQ(latest.wait_newer(0, kLong)->value, 5); });
  latest.put(5);
  reader.join();
}

TEST(Latest, ReadersSeeRisingVersionsAndTheLastValue) {
  Latest<int> latest;
  constexpr int kLast = 5000;
  std::vector<std::thread> readers;
  for (int r = 0; r < 2; ++r) {
    readers.emplace_back([&] {
      std::uint64_t version = 0;
      int value = 0;
      while (value < kLast) {
        const auto seen = latest.wait_newer(version, kLong);
        ASSERT_TRUE(seen.has_value());
        ASSERT_GT(seen->version, version);
        ASSERT_GT(seen->value, value);
        version = seen->version;
        value = seen->value;
      }
    });
  }
  for (int i = 1; i <= kLast; ++i) latest.put(i);
  for (auto& reader : readers) reader.join();
}

}  // namespace
}  // namespace sslv
