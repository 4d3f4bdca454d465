// SPDX-License-Identifier: Apache-2.0
#include "services/cameras/loss_log.h"

#include <vector>

#include <gmock/gmock.h>

namespace sslv::loss_log_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

Timeline::Sum second_with(std::uint64_t dropped, std::uint64_t incomplete) {
  return {.seconds = 1, .frames = 60 - dropped - incomplete, .dropped = dropped, .incomplete = incomplete};
}

/// The log's lines, and the second in which each was written.
struct Lines {
  LossLog log;
  std::vector<std::pair<int, std::string>> said;
  std::vector<bool> ends;
  void look(int from_s, int to_s, std::uint64_t dropped, std::uint64_t incomplete = 0) {
    for (int s = from_s; s <= to_s; ++s) {
      const auto line = log.look(second_with(dropped, incomplete), s);
      if (!line) continue;
      said.emplace_back(s, line->text);
      ends.push_back(line->is_end);
    }
  }
};

TEST(LossLog, SaysNothingWhileNothingIsLost) {
  Lines lines;
  lines.look(1, 1000, 0);
  EXPECT_THAT(lines.said, IsEmpty());
}

TEST(LossLog, LogsALossThenOnceAMinuteThenItsEnd) {
  Lines lines;
  lines.look(1, 10, 0);
  lines.look(11, 100, 2, 1);
  lines.look(101, 500, 0);
  using Line = std::pair<int, std::string>;
  EXPECT_THAT(
      lines.said,
      ElementsAre(Line{20,
                       "30 of 600 images lost in the last 10 s: 20 were not processed in time, 10 arrived "
                       "damaged"},
                  Line{80,
                       "180 of 3600 images lost in the last 60 s: 120 were not processed in time, 60 arrived "
                       "damaged"},
                  Line{140,
                       "60 of 3600 images lost in the last 60 s: 40 were not processed in time, 20 arrived "
                       "damaged"},
                  Line{200, "no image lost in the last 100 s; 270 were lost in the 90 s before"}));
  EXPECT_THAT(lines.ends, ElementsAre(false, false, false, true));
}

TEST(LossLog, ResetsAfterItsEnd) {
  Lines lines;
  lines.look(1, 1, 1);
  lines.look(2, 200, 0);
  EXPECT_THAT(lines.ends, ElementsAre(false, true));
  lines.look(201, 201, 0, 1);
  lines.look(202, 210, 0);
  ASSERT_EQ(lines.said.size(), 3U);
  EXPECT_EQ(lines.said[2].second,
            "1 of 600 images lost in the last 10 s: 0 were not processed in time, 1 arrived damaged");
}

TEST(LossLog, NeverSaysMoreThanALineAMinute) {
  Lines lines;
  for (int s = 1; s < 5000; ++s) lines.look(s, s, s % 500 < 200 && s % 7 == 0 ? 1 : 0);
  for (std::size_t i = 1; i < lines.said.size(); ++i)
    EXPECT_GE(lines.said[i].first - lines.said[i - 1].first, 60);
  EXPECT_GT(lines.said.size(), 30U);
}

}  // namespace
}  // namespace sslv::loss_log_test
