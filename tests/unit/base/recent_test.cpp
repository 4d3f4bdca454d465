// SPDX-License-Identifier: Apache-2.0
#include "base/recent.h"

#include <thread>

#include <gtest/gtest.h>

namespace sslv::recent_test {
namespace {

TEST(RecentDurations, AreZeroBeforeTheFirst) {
  const RecentDurations recent;
  EXPECT_EQ(recent.percentiles().p50_us, 0);
  EXPECT_EQ(recent.percentiles().p99_us, 0);
}

TEST(RecentDurations, OneSampleIsEveryPercentile) {
  RecentDurations recent;
  recent.add_ns(2500);
  EXPECT_DOUBLE_EQ(recent.percentiles().p50_us, 2.5);
  EXPECT_DOUBLE_EQ(recent.percentiles().p99_us, 2.5);
}

TEST(RecentDurations, PercentilesInAnyOrderOfArrival) {
  RecentDurations recent;
  for (int i = 0; i < 200; ++i) recent.add_ns((i * 77 % 200) * 1000);  // 0 .. 199 us, shuffled
  EXPECT_DOUBLE_EQ(recent.percentiles().p50_us, 100);
  EXPECT_DOUBLE_EQ(recent.percentiles().p99_us, 198);
}

TEST(RecentDurations, ForgetsAllButTheLast512) {
  RecentDurations recent;
  for (int i = 0; i < 1000; ++i) recent.add_ns(9'000'000);
  for (int i = 0; i < 512; ++i) recent.add_ns(1000);
  EXPECT_DOUBLE_EQ(recent.percentiles().p99_us, 1);
}

TEST(RecentDurations, GivesThoseThatCameSince) {
  RecentDurations recent;
  for (int i = 0; i < 600; ++i) recent.add_ns(1000);
  EXPECT_EQ(recent.samples_ns().size(), 512u);
  const std::uint64_t before = recent.count();
  EXPECT_EQ(before, 600u);
  recent.add_ns(7000);
  recent.add_ns(9000);
  EXPECT_EQ(recent.samples_ns(before), (std::vector<std::int64_t>{7000, 9000}));
  EXPECT_DOUBLE_EQ(recent.percentiles(before).p50_us, 9);
  EXPECT_DOUBLE_EQ(recent.percentiles(recent.count()).p99_us, 0);
}

TEST(RecentDurations, MayBeReadWhileWritten) {
  RecentDurations recent;
  std::thread writer([&] {
    for (int i = 0; i < 20000; ++i) recent.add_ns(i % 2 == 0 ? 1000 : 3000);
  });
  for (int i = 0; i < 100; ++i) {
    const auto seen = recent.percentiles();
    EXPECT_LE(seen.p50_us, seen.p99_us);
    EXPECT_LE(seen.p99_us, 3);
  }
  writer.join();
  EXPECT_DOUBLE_EQ(recent.percentiles().p99_us, 3);
}

}  // namespace
}  // namespace sslv::recent_test
