// SPDX-License-Identifier: Apache-2.0
#include "services/recording/match_rule.h"

#include <string>

#include <gtest/gtest.h>

namespace sslv::match_rule_test {
namespace {

using Wish = MatchRule::Wish;

constexpr int kBeforeFirstHalf = 0, kFirstHalf = 1, kHalfTime = 2, kSecondHalf = 4, kFinished = 13;

RefereeStatus referee(int stage, bool is_halted, std::string yellow = "Immortals",
                      std::string blue = "TIGERs") {
  RefereeStatus status;
  status.team_names = {std::move(yellow), std::move(blue)};
  status.silent_s = 0.1;
  status.match =
      MatchState{.stage = stage, .type = 1, .is_halted = is_halted, .time_left_s = {}, .score = {}};
  return status;
}

TEST(MatchRule, RecordsFromTheFirstCommandToTheEndAndPausesInBreaks) {
  MatchRule rule;
  EXPECT_EQ(rule.look({}), Wish::kNone) << "there is no game controller";
  EXPECT_EQ(rule.look(referee(kBeforeFirstHalf, true)), Wish::kNone) << "HALT";
  EXPECT_EQ(rule.look(referee(kBeforeFirstHalf, false)), Wish::kRecord);
  EXPECT_EQ(rule.name(), "GROUP_PHASE_Immortals-vs-TIGERs");
  EXPECT_EQ(rule.look(referee(kFirstHalf, true)), Wish::kRecord) << "a HALT in a match is a part of it";
  EXPECT_EQ(rule.look(referee(kHalfTime, true)), Wish::kPause);
  EXPECT_EQ(rule.look(referee(kSecondHalf, true)), Wish::kRecord);
  EXPECT_EQ(rule.look(referee(kFinished, true)), Wish::kNone);
  EXPECT_EQ(rule.look(referee(kFirstHalf, false)), Wish::kRecord) << "the next match of the same teams";
}

TEST(MatchRule, NeedsBothNames) {
  MatchRule rule;
  EXPECT_EQ(rule.look(referee(kFirstHalf, false, "")), Wish::kNone);
  EXPECT_EQ(rule.look(referee(kFirstHalf, false, "Immortals", "")), Wish::kNone);
}

TEST(MatchRule, ASilentGameControllerEndsTheMatchOnlyLater) {
  MatchRule rule;
  ASSERT_EQ(rule.look(referee(kFirstHalf, false)), Wish::kRecord);
  RefereeStatus silent = referee(kFirstHalf, false);
  silent.silent_s = 300;
  EXPECT_EQ(rule.look(silent), Wish::kRecord);
  silent.silent_s = 700;
  EXPECT_EQ(rule.look(silent), Wish::kNone);
}

TEST(MatchRule, AnotherTeamNameStartsAnotherMatch) {
  MatchRule rule;
  ASSERT_EQ(rule.look(referee(kFirstHalf, false)), Wish::kRecord);
  EXPECT_EQ(rule.look(referee(kFirstHalf, true, "Another")), Wish::kNone) << "which begins when HALT is over";
  EXPECT_EQ(rule.look(referee(kFirstHalf, false, "Another")), Wish::kRecord);
  EXPECT_EQ(rule.name(), "GROUP_PHASE_Another-vs-TIGERs");
}

TEST(MatchRule, TeamsThatSwitchColoursContinueTheirMatch) {
  MatchRule rule;
  ASSERT_EQ(rule.look(referee(kFirstHalf, false)), Wish::kRecord);
  const int number = rule.number();
  ASSERT_EQ(rule.look(referee(kHalfTime, true)), Wish::kPause);
  EXPECT_EQ(rule.look(referee(kHalfTime, true, "TIGERs", "Immortals")), Wish::kPause);
  EXPECT_EQ(rule.look(referee(kSecondHalf, true, "TIGERs", "Immortals")), Wish::kRecord);
  EXPECT_EQ(rule.number(), number);
  EXPECT_EQ(rule.name(), "GROUP_PHASE_Immortals-vs-TIGERs");
  rule.leave_match_out();
  EXPECT_EQ(rule.look(referee(kSecondHalf, false)), Wish::kNone) << "as they were";
}

TEST(MatchRule, AnotherMatchIsAnotherOneWhateverItsFileIsCalled) {
  MatchRule rule;
  ASSERT_EQ(rule.look(referee(kFirstHalf, false, "日本", "中国")), Wish::kRecord);
  const int number = rule.number();
  ASSERT_EQ(rule.look(referee(kHalfTime, true, "日本", "中国")), Wish::kPause);
  EXPECT_EQ(rule.number(), number);
  ASSERT_EQ(rule.look(referee(kFirstHalf, false, "韓国", "台湾")), Wish::kRecord);
  EXPECT_NE(rule.number(), number);
}

TEST(MatchRule, AMatchThatIsLeftOutStaysSoUntilItEnds) {
  MatchRule rule;
  ASSERT_EQ(rule.look(referee(kFirstHalf, false)), Wish::kRecord);
  EXPECT_FALSE(rule.leaves_match_out());
  rule.leave_match_out();
  EXPECT_TRUE(rule.leaves_match_out());
  EXPECT_EQ(rule.look(referee(kFirstHalf, false)), Wish::kNone);
  EXPECT_EQ(rule.look(referee(kHalfTime, true)), Wish::kNone);
  EXPECT_EQ(rule.look(referee(kSecondHalf, false)), Wish::kNone);
  EXPECT_TRUE(rule.leaves_match_out());
  EXPECT_EQ(rule.look(referee(kFinished, true)), Wish::kNone);
  EXPECT_FALSE(rule.leaves_match_out());
  EXPECT_EQ(rule.look(referee(kFirstHalf, false)), Wish::kRecord);
  rule.leave_match_out();
  EXPECT_EQ(rule.look(referee(kFirstHalf, false, "Another")), Wish::kRecord);
}

TEST(FileNamePart, HasNothingThatAFileNameMayNotHave) {
  EXPECT_EQ(file_name_part("TIGERs Mannheim"), "TIGERs_Mannheim");
  EXPECT_EQ(file_name_part("../../etc"), "_._.._etc");
  EXPECT_EQ(file_name_part("ÜñÏ"), "_");
  EXPECT_EQ(file_name_part(std::string("a\0b/\\\n", 6)), "a_b_");
  EXPECT_EQ(file_name_part(std::string(500, 'x')).size(), 60U);
}

}  // namespace
}  // namespace sslv::match_rule_test
