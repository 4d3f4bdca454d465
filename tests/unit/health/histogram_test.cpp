// SPDX-License-Identifier: Apache-2.0
#include "health/histogram.h"

#include "base/recent.h"

#include <numeric>

#include <gmock/gmock.h>

namespace sslv::histogram_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(Histogram, IsEmptyWithoutDurations) {
  const Histogram histogram = make_histogram({});
  EXPECT_THAT(histogram.edges_us, IsEmpty());
  EXPECT_THAT(histogram.counts, IsEmpty());
}

TEST(Histogram, HasTheBinsFromTheFirstToTheLastThatIsNeeded) {
  const std::vector<std::int64_t> durations_ns{100'500, 101'000, 300'000};
  const Histogram histogram = make_histogram(durations_ns);
  ASSERT_EQ(histogram.edges_us.size(), histogram.counts.size() + 1);
  EXPECT_NEAR(histogram.edges_us.front(), 100, 1e-6);
  EXPECT_THAT(histogram.counts, ElementsAre(2, 0, 0, 0, 0, 1));
  for (std::size_t i = 1; i < histogram.edges_us.size(); ++i)
    EXPECT_NEAR(histogram.edges_us[i] / histogram.edges_us[i - 1], 1.2115, 1e-3);
  EXPECT_LE(histogram.edges_us[5], 300);
  EXPECT_GT(histogram.edges_us[6], 300);
}

TEST(Histogram, CountsWhatIsOutOfItsRangeToo) {
  const std::vector<std::int64_t> durations_ns{-5, 0, 1, 60'000'000'000};
  const Histogram histogram = make_histogram(durations_ns);
  EXPECT_EQ(histogram.counts.front(), 3u);
  EXPECT_EQ(histogram.counts.back(), 1u);
  EXPECT_NEAR(histogram.edges_us.back(), 1e7, 1);
}

TEST(Histogram, OfRecentDurationsHasAllThatAreKept) {
  RecentDurations recent;
  for (int i = 0; i < 2000; ++i) recent.add_ns(1000 + 10'000 * (i % 7));
  const Histogram histogram = make_histogram(recent.samples_ns());
  EXPECT_EQ(std::accumulate(histogram.counts.begin(), histogram.counts.end(), 0u), 512u);
}

}  // namespace
}  // namespace sslv::histogram_test
