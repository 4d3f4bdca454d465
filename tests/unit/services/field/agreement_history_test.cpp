// SPDX-License-Identifier: Apache-2.0
#include "services/field/agreement_history.h"

#include <gtest/gtest.h>

namespace sslv::agreement_history_test {
namespace {

CameraPairNow apart(double off_mm) {
  return {.camera = 2, .other = 0, .off_mm = off_mm, .parts = 9, .worst_mm = {0, 0}};
}

TEST(AgreementHistory, RecordsWhenADifferenceBeganAndTheValueBefore) {
  AgreementHistory history;
  double t_s = 1e9;
  for (int i = 0; i < 300; ++i) history.add({apart(1.25)}, t_s += 1);
  ASSERT_TRUE(history.of(0, 2));
  EXPECT_FALSE(history.of(2, 0)->since_s);
  for (int i = 0; i < 61; ++i) history.add({apart(1.25 + 0.06 * i)}, t_s += 1);  // a mean rises slowly
  const double bumped_s = t_s + 1;
  for (int i = 0; i < 100; ++i) history.add({apart(7)}, t_s += 1);
  EXPECT_EQ(history.of(0, 2)->since_s, bumped_s);
  EXPECT_EQ(history.of(0, 2)->before_mm, 1.25);
  history.add({apart(4.5)}, t_s += 1);
  EXPECT_TRUE(history.of(0, 2)->since_s) << "near the limit it does not come and go";
  history.add({apart(1)}, t_s += 1);
  EXPECT_FALSE(history.of(0, 2)->since_s);
}

TEST(AgreementHistory, KeepsAValueForEachMinuteOfTwoHours) {
  AgreementHistory history;
  for (int i = 0; i < 3 * 3600; ++i) history.add({apart(i < 5400 ? 1 : 3)}, 1e9 + i);
  const Json trends = history.to_json();
  ASSERT_EQ(trends.size(), 1U);
  const Json& minutes = trends[0].at("minutes");
  ASSERT_NEAR(static_cast<double>(minutes.size()), 120, 1);
  EXPECT_EQ(minutes[0].at("off_mm"), 1);
  EXPECT_EQ(minutes.back().at("off_mm"), 3);
  EXPECT_EQ(minutes[119].at("time").get<double>() - minutes[118].at("time").get<double>(), 60);
  EXPECT_TRUE(trends[0].at("since").is_null());
}

TEST(AgreementHistory, HasNoValueBeforeTheFirstSample) {
  AgreementHistory history;
  history.add({apart(7)}, 1e9);
  EXPECT_TRUE(history.of(0, 2)->since_s);
  EXPECT_FALSE(history.of(0, 2)->before_mm);
  EXPECT_TRUE(history.to_json()[0].at("before_mm").is_null());
}

TEST(AgreementHistory, ForgetsPairsThatWereNotComparedForLong) {
  AgreementHistory history;
  history.add({apart(7)}, 1e9);
  for (int i = 1; i < 590; ++i) history.add({}, 1e9 + i);
  EXPECT_TRUE(history.of(0, 2)->since_s);
  for (int i = 590; i < 620; ++i) history.add({}, 1e9 + i);
  EXPECT_FALSE(history.of(0, 2)->since_s) << "they may have been calibrated";
}

TEST(AgreementHistory, DropsMinutesFromBeforeTheClockWasSetForward) {
  AgreementHistory history;
  history.add({apart(1)}, 1.5e9);
  history.add({apart(1)}, 1.7e9);
  EXPECT_EQ(history.of(0, 2)->minutes.size(), 1U);
}

TEST(AgreementHistory, ForgetsCamerasThatAreGone) {
  AgreementHistory history;
  history.add({apart(1)}, 1e9);
  history.add({}, 1e9 + 7000);
  EXPECT_TRUE(history.of(0, 2));
  history.add({}, 1e9 + 7300);
  EXPECT_FALSE(history.of(0, 2));
}

TEST(AgreementHistory, BeginsAgainWhenTheClockIsSetBack) {
  AgreementHistory history;
  for (int i = 0; i < 300; ++i) history.add({apart(7)}, 1e9 + i);
  history.add({apart(1)}, 1e9 - 3600);
  EXPECT_FALSE(history.of(0, 2)->since_s);
  EXPECT_EQ(history.of(0, 2)->minutes.size(), 1U);
}

}  // namespace
}  // namespace sslv::agreement_history_test
