// SPDX-License-Identifier: Apache-2.0
#include "base/log_ring.h"

#include "base/log.h"

#include <gtest/gtest.h>

namespace sslv::log {
namespace {

TEST(LogRing, NumbersLinesAndGivesThoseThatAreNew) {
  LogRing ring;
  EXPECT_EQ(ring.newer_than(0, Level::kDebug).newest, 0u);
  ring.add(1.5, Level::kInfo, "one");
  ring.add(2.5, Level::kWarning, "two");
  const auto all = ring.newer_than(0, Level::kDebug);
  ASSERT_EQ(all.lines.size(), 2u);
  EXPECT_EQ(all.newest, 2u);
  EXPECT_EQ(all.lines[0].seq, 1u);
  EXPECT_EQ(all.lines[0].time_s, 1.5);
  EXPECT_EQ(all.lines[1].text, "two");
  const auto fresh = ring.newer_than(1, Level::kDebug);
  ASSERT_EQ(fresh.lines.size(), 1u);
  EXPECT_EQ(fresh.lines[0].seq, 2u);
  EXPECT_TRUE(ring.newer_than(2, Level::kDebug).lines.empty());
}

TEST(LogRing, ReturnsAllForANumberOfAnEarlierRun) {
  LogRing ring;
  ring.add(0, Level::kInfo, "one");
  EXPECT_EQ(ring.newer_than(77, Level::kDebug).lines.size(), 1u);
}

TEST(LogRing, OmitsLessSevereLines) {
  LogRing ring;
  for (const Level level : {Level::kDebug, Level::kInfo, Level::kWarning, Level::kError})
    ring.add(0, level, name_of(level));
  const auto [lines, newest] = ring.newer_than(0, Level::kWarning);
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0].text, "warning");
  EXPECT_EQ(lines[1].text, "error");
  EXPECT_EQ(newest, 4u);
}

TEST(LogRing, KeepsTheNewestThousand) {
  LogRing ring;
  for (int i = 1; i <= 1500; ++i) ring.add(0, Level::kInfo, std::to_string(i));
  const auto [lines, newest] = ring.newer_than(0, Level::kDebug);
  ASSERT_EQ(lines.size(), LogRing::kMaxLines);
  EXPECT_EQ(lines.front().text, "501");
  EXPECT_EQ(newest, 1500u);
}

TEST(LogRing, IsBoundedInBytes) {
  LogRing ring;
  const std::string longest(10 * LogRing::kLongestLine, 'x');
  for (int i = 0; i < 200; ++i) ring.add(0, Level::kInfo, longest);
  std::size_t bytes = 0;
  for (const auto& line : ring.newer_than(0, Level::kDebug).lines) bytes += line.text.size();
  EXPECT_LE(bytes, LogRing::kMaxBytes);
  EXPECT_GT(bytes, LogRing::kMaxBytes / 2);
}

TEST(LogLevels, AreFoundByTheirNames) {
  for (const Level level : {Level::kDebug, Level::kInfo, Level::kWarning, Level::kError})
    EXPECT_EQ(level_named(name_of(level)), level);
  EXPECT_EQ(level_named("loud"), std::nullopt);
}

TEST(Log, KeepsWhatItWrites) {
  const std::uint64_t before = recent().newer_than(0, Level::kDebug).newest;
  warning("a test says {}", 42);
  debug("below the level: not written");
  const auto [lines, newest] = recent().newer_than(before, Level::kDebug);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0].text, "a test says 42");
  EXPECT_EQ(lines[0].level, Level::kWarning);
}

}  // namespace
}  // namespace sslv::log
