// SPDX-License-Identifier: Apache-2.0
#include "health/metrics_text.h"

#include <limits>

#include <gmock/gmock.h>

namespace sslv::metrics_text_test {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST(MetricsText, HasHelpTypeAndSamplesOfEachFamily) {
  MetricsText out;
  out.begin("frames_total", "counter", "Pictures.");
  out.add({{"camera", "0"}}, std::uint64_t{18'446'744'073'709'551'615u});
  out.add({{"camera", "1"}, {"reason", "late"}}, std::uint64_t{0});
  out.begin("offset_seconds", "gauge", "The clock's.");
  out.add({}, -2.5e-7);
  EXPECT_EQ(out.take(),
            "# HELP frames_total Pictures.\n"
            "# TYPE frames_total counter\n"
            "frames_total{camera=\"0\"} 18446744073709551615\n"
            "frames_total{camera=\"1\",reason=\"late\"} 0\n"
            "# HELP offset_seconds The clock's.\n"
            "# TYPE offset_seconds gauge\n"
            "offset_seconds -2.5e-07\n");
}

TEST(MetricsText, LeavesAFamilyWithoutSamplesOut) {
  MetricsText out;
  out.begin("nothing", "gauge", "Nobody knows.");
  out.begin("one", "gauge", "1.");
  out.add({}, 1.0);
  EXPECT_EQ(out.take(), "# HELP one 1.\n# TYPE one gauge\none 1\n");
}

TEST(MetricsText, EscapesWhatWouldEndALineOrALabel) {
  MetricsText out;
  out.begin("one", "gauge", "a \\ \"b\"\nc");
  out.add({{"name", "a \\ \"b\"\nc"}}, 1.0);
  EXPECT_EQ(out.take(),
            "# HELP one a \\\\ \"b\"\\nc\n# TYPE one gauge\none{name=\"a \\\\ \\\"b\\\"\\nc\"} 1\n");
}

TEST(MetricsText, WritesNonFiniteValuesAsPrometheusReadsThem) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  MetricsText out;
  out.begin("one", "gauge", "1.");
  for (const double value : {kInfinity, -kInfinity, std::numeric_limits<double>::quiet_NaN()})
    out.add({}, value);
  EXPECT_THAT(out.take(), EndsWith("\none +Inf\none -Inf\none NaN\n"));
}

TEST(MetricsText, AHistogramsBucketsAddUp) {
  DurationTotals totals;
  for (const std::int64_t duration_ns : {10'000, 20'000, 2'000'000}) totals.add_ns(duration_ns);
  totals.add_ns(5'000'000'000);
  MetricsText out;
  out.begin("took_seconds", "histogram", "Time.");
  out.add({{"camera", "0"}}, totals.read());
  const std::string text = out.take();
  EXPECT_THAT(text, StartsWith("# HELP took_seconds Time.\n# TYPE took_seconds histogram\n"
                               "took_seconds_bucket{camera=\"0\",le=\"1e-05\"} 1\n"
                               "took_seconds_bucket{camera=\"0\",le=\"2.5e-05\"} 2\n"));
  EXPECT_THAT(text, HasSubstr("\ntook_seconds_bucket{camera=\"0\",le=\"0.0075\"} 3\n"));
  EXPECT_THAT(text, EndsWith("took_seconds_bucket{camera=\"0\",le=\"1\"} 3\n"
                             "took_seconds_bucket{camera=\"0\",le=\"+Inf\"} 4\n"
                             "took_seconds_sum{camera=\"0\"} 5.00203\n"
                             "took_seconds_count{camera=\"0\"} 4\n"));
}

}  // namespace
}  // namespace sslv::metrics_text_test
