// SPDX-License-Identifier: Apache-2.0
#include "base/duration_totals.h"

#include <numeric>
#include <thread>

#include <gtest/gtest.h>

namespace sslv::duration_totals_test {
namespace {

TEST(DurationTotals, ADurationCountsInTheFirstBucketThatHoldsIt) {
  DurationTotals totals;
  totals.add_ns(-7);
  totals.add_ns(10'000);
  totals.add_ns(10'001);
  totals.add_ns(1'000'000'000);
  totals.add_ns(1'000'000'001);
  const auto reading = totals.read();
  EXPECT_EQ(reading.counts.front(), 2u) << "a bucket's end is in it; nothing is negative";
  EXPECT_EQ(reading.counts[1], 1u);
  EXPECT_EQ(reading.counts[reading.counts.size() - 2], 1u);
  EXPECT_EQ(reading.counts.back(), 1u);
  EXPECT_EQ(reading.sum_ns, 2'000'020'002u);
}

TEST(DurationTotals, ManyThreadsMayAdd) {
  DurationTotals totals;
  const auto add = [&] {
    for (int i = 0; i < 10'000; ++i) totals.add_ns(i);
  };
  { const std::jthread one(add), two(add); }
  const auto reading = totals.read();
  EXPECT_EQ(std::accumulate(reading.counts.begin(), reading.counts.end(), std::uint64_t{0}), 20'000u);
  EXPECT_EQ(reading.sum_ns, 2u * 9'999 * 10'000 / 2);
}

}  // namespace
}  // namespace sslv::duration_totals_test
