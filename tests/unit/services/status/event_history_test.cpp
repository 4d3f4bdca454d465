// SPDX-License-Identifier: Apache-2.0
#include "services/status/event_history.h"

#include <gmock/gmock.h>

namespace sslv::event_history_test {
namespace {

using Now = EventHistory::Now;
constexpr double kUnix_s = 1'790'000'000;

Now at(double steady_s, double clock_set_by_s = 0) {
  return {kUnix_s + steady_s + clock_set_by_s, steady_s};
}

Alert lost(int camera, Severity severity = Severity::kBad, std::string title = "lost") {
  return {.id = "camera_lost",
          .check = "cameras",
          .severity = severity,
          .title = std::move(title),
          .fix = "",
          .camera = camera};
}

/// Passes the same alerts once a second.
void look(EventHistory& history, const std::vector<Alert>& alerts, double from_s, double to_s,
          double clock_set_by_s = 0) {
  for (double s = from_s; s <= to_s; ++s) history.look(alerts, at(s, clock_set_by_s));
}

TEST(EventHistory, TellsWhenAnAlertCameAndHowLongItWasThere) {
  EventHistory history;
  look(history, {}, 1, 2);
  look(history, {lost(3)}, 3, 136);
  ASSERT_EQ(history.entries_json().size(), 1U);
  EXPECT_TRUE(history.entries_json()[0]["end"].is_null());
  look(history, {}, 137, 145);
  const Json entry = history.entries_json()[0];
  EXPECT_EQ(entry["kind"], "alert");
  EXPECT_EQ(entry["id"], "camera_lost");
  EXPECT_EQ(entry["severity"], "bad");
  EXPECT_EQ(entry["camera"], 3);
  EXPECT_EQ(entry["begin"], kUnix_s + 3);
  EXPECT_EQ(entry["end"], kUnix_s + 136);
  EXPECT_EQ(entry["seconds"], 133);
  EXPECT_EQ(entry["count"], 1);
  EXPECT_EQ(entry["ended_by"], "");
}

TEST(EventHistory, AShortGapDoesNotEndAnAlert) {
  EventHistory history;
  look(history, {lost(0)}, 1, 10);
  look(history, {}, 11, 14);
  look(history, {lost(0)}, 15, 20);
  const Json entries = history.entries_json();
  ASSERT_EQ(entries.size(), 1U);
  EXPECT_EQ(entries[0]["count"], 1);
  EXPECT_EQ(entries[0]["seconds"], 19);
}

TEST(EventHistory, EarlyRepeatsAreCountedAndLateOnesAreNewEntries) {
  EventHistory history;
  look(history, {lost(0)}, 1, 10);
  look(history, {}, 11, 40);
  look(history, {lost(0)}, 41, 45);
  ASSERT_EQ(history.entries_json().size(), 1U);
  EXPECT_EQ(history.entries_json()[0]["count"], 2);
  EXPECT_EQ(history.entries_json()[0]["seconds"], 9 + 4) << "only while it was there";
  look(history, {}, 46, 110);
  look(history, {lost(0)}, 111, 112);
  ASSERT_EQ(history.entries_json().size(), 2U);
  EXPECT_EQ(history.entries_json()[0]["begin"], kUnix_s + 111) << "newest first";
}

TEST(EventHistory, AlertsOfOneKindAreToldApart) {
  EventHistory history;
  Alert other = lost(0);
  other.about = "10.0.0.1";
  history.look({lost(0), lost(1), other}, at(1));
  history.look({lost(0), lost(1), other}, at(2));
  EXPECT_EQ(history.entries_json().size(), 3U);
}

TEST(EventHistory, KeepsTheWorst) {
  EventHistory history;
  history.look({lost(0, Severity::kWarn, "a few")}, at(1));
  history.look({lost(0, Severity::kBad, "37 of 600")}, at(2));
  history.look({lost(0, Severity::kBad, "38 of 600")}, at(3));
  history.look({lost(0, Severity::kWarn, "1 of 600")}, at(4));
  const Json entry = history.entries_json()[0];
  EXPECT_EQ(entry["severity"], "bad");
  EXPECT_EQ(entry["title"], "38 of 600");
  EXPECT_EQ(entry["seconds"], 3);
}

TEST(EventHistory, OnlyBeginningAndEndingAreChanges) {
  EventHistory history;
  history.look({lost(0)}, at(1));
  const auto before = history.changes();
  EXPECT_GT(before, 0U);
  history.look({lost(0, Severity::kBad, "another figure")}, at(2));
  EXPECT_EQ(history.changes(), before);
  look(history, {}, 3, 8);
  EXPECT_GT(history.changes(), before);
}

TEST(EventHistory, SettingTheClockIsReportedAndKeepsDurations) {
  for (const double set_by_s : {3600.0, -3600.0}) {
    EventHistory history;
    look(history, {lost(0)}, 1, 10);
    look(history, {lost(0)}, 11, 20, set_by_s);
    look(history, {}, 21, 30, set_by_s);
    const Json entries = history.entries_json();
    ASSERT_EQ(entries.size(), 2U);
    EXPECT_EQ(entries[0]["id"], "clock_set");
    EXPECT_EQ(entries[0]["title"], set_by_s > 0 ? "The computer's clock was set forward by 1 h 0 min"
                                                : "The computer's clock was set back by 1 h 0 min");
    EXPECT_EQ(entries[1]["seconds"], 19);
    EXPECT_EQ(entries[1]["begin"], kUnix_s + set_by_s + 1) << "as the clock has it now";
    EXPECT_EQ(entries[1]["end"], kUnix_s + set_by_s + 20);
  }
}

TEST(EventHistory, AClockThatIsAdjustedSlowlyIsNotSet) {
  EventHistory history;
  for (int s = 1; s < 1000; ++s) history.look({}, at(s, 5e-4 * s));
  EXPECT_TRUE(history.entries_json().empty());
}

TEST(EventHistory, TheSameEventSoonAfterIsCounted) {
  EventHistory history;
  const Event change{"settings_changed", "Settings changed: /site", "10.0.0.7"};
  history.add(change, at(1));
  history.add(change, at(30));
  Event other = change;
  other.who = "10.0.0.8";
  history.add(other, at(31));
  history.add(change, at(200));
  const Json entries = history.entries_json();
  ASSERT_EQ(entries.size(), 3U);
  EXPECT_EQ(entries[2]["count"], 2);
  EXPECT_EQ(entries[2]["end"], kUnix_s + 30);
  EXPECT_EQ(entries[2]["seconds"], 0);
  EXPECT_EQ(entries[2]["who"], "10.0.0.7");
}

TEST(EventHistory, ForgetsAfterADayButNotWhatIsStillThere) {
  EventHistory history;
  history.look({lost(0), lost(1)}, at(1));
  history.add({"settings_changed", "s"}, at(1));
  look(history, {lost(1)}, 2, 10);
  ASSERT_EQ(history.entries_json().size(), 3U);
  history.look({lost(1)}, at(EventHistory::kKept_s + 5));
  const Json entries = history.entries_json();
  ASSERT_EQ(entries.size(), 1U);
  EXPECT_EQ(entries[0]["camera"], 1);
}

TEST(EventHistory, DropsTheOldestEndedEntriesWhenFull) {
  EventHistory history;
  history.look({lost(7)}, at(0));
  for (int i = 0; i < 2000; ++i) history.add({"settings_changed", std::to_string(i)}, at(0.001 * i));
  const Json entries = history.entries_json();
  ASSERT_EQ(entries.size(), EventHistory::kMaxEntries);
  EXPECT_EQ(entries.front()["title"], "1999");
  EXPECT_EQ(entries.back()["camera"], 7) << "it is still there";
}

TEST(EventHistory, ManyAlertsAtOnceAreBounded) {
  EventHistory history;
  std::vector<Alert> alerts;
  for (int i = 0; i < 3000; ++i) alerts.push_back(lost(i));
  history.look(alerts, at(1));
  EXPECT_EQ(history.entries_json().size(), EventHistory::kMaxEntries);
}

TEST(EventHistory, TextIsPlainAndShort) {
  EventHistory history;
  Alert alert = lost(0, Severity::kBad, "\x1b[31m" + std::string(5000, 'x') + "\xff");
  alert.about = std::string(5000, 'y');
  history.look({alert}, at(1));
  history.look({alert}, at(2));
  const Json entries = history.entries_json();
  ASSERT_EQ(entries.size(), 1U) << "it is known again";
  EXPECT_LE(entries[0]["title"].get<std::string>().size(), EventHistory::kMaxTextBytes);
  EXPECT_TRUE(entries[0]["title"].get<std::string>().starts_with("\\u001b"));
}

TEST(EventHistory, OpenAlertsEndWhenTheServiceDies) {
  EventHistory before;
  look(before, {lost(0)}, 1, 60);
  before.add({"settings_changed", "Settings changed: /site", "10.0.0.7"}, at(60));
  const Json saved = before.to_saved();

  EventHistory history;  // of another run, whose steady clock is unrelated
  history.load(saved, {kUnix_s + 100, 7});
  Json entries = history.entries_json();
  ASSERT_EQ(entries.size(), 2U);
  EXPECT_EQ(entries[1]["end"], kUnix_s + 60);
  EXPECT_EQ(entries[1]["seconds"], 59);
  EXPECT_EQ(entries[1]["ended_by"], "the service ended");
  EXPECT_EQ(entries[0]["who"], "10.0.0.7");
  EXPECT_EQ(entries[0]["ended_by"], "");

  history.look({lost(0)}, {kUnix_s + 101, 8});
  entries = history.entries_json();
  ASSERT_EQ(entries.size(), 3U);
  EXPECT_TRUE(entries[0]["end"].is_null()) << "another one";
  EXPECT_EQ(entries[2]["seconds"], 59);
}

TEST(EventHistory, RepeatedCrashesShareOneEntry) {
  const Event started{"service_started", "The service started"}, restarted{"service_restarted", "again"},
      stopped{"service_stopped", "The service stopped"};
  Json saved = Json::array();
  const auto run = [&](const Event& start, double unix_s, bool stops) {
    EventHistory history;
    history.load(saved, {kUnix_s + unix_s, 1});
    history.add(start, {kUnix_s + unix_s, 1});
    if (stops) history.add(stopped, {kUnix_s + unix_s, 2});
    saved = history.to_saved();
  };
  run(started, 0, false);
  for (int i = 1; i < 20; ++i) run(restarted, 10 * i, false);
  ASSERT_EQ(saved.size(), 2U);
  EXPECT_EQ(saved[1]["count"], 19);
  run(restarted, 200, true);
  run(started, 201, true);
  run(started, 202, true);
  EXPECT_EQ(saved.size(), 2U + 1 + 4) << "starts after stops are told one by one";
}

TEST(EventHistory, OpenAlertsEndWhenTheServiceStops) {
  EventHistory history;
  look(history, {lost(0)}, 1, 9);
  EXPECT_TRUE(history.any_open());
  history.end_all(at(10));
  EXPECT_FALSE(history.any_open());
  EXPECT_EQ(history.entries_json()[0]["ended_by"], "the service ended");
  EXPECT_EQ(history.entries_json()[0]["end"], kUnix_s + 9);
}

TEST(EventHistory, EarlierRunsAreForgottenAfterADayTooAndKeepTheirTimesWhenTheClockIsSet) {
  EventHistory before;
  before.add({"settings_changed", "old"}, at(0));
  before.add({"settings_changed", "new"}, at(1000));
  EventHistory history;
  history.load(before.to_saved(), {kUnix_s + EventHistory::kKept_s + 500, 1});
  ASSERT_EQ(history.entries_json().size(), 1U);
  history.look({}, {kUnix_s + EventHistory::kKept_s + 500, 1});
  history.look({}, {kUnix_s + EventHistory::kKept_s + 500 - 3600, 2});
  EXPECT_EQ(history.entries_json()[1]["begin"], kUnix_s + 1000);
}

TEST(EventHistory, DropsInvalidEntries) {
  EventHistory before;
  before.add({"settings_changed", "good"}, at(0));
  Json saved = before.to_saved();
  saved.push_back(7);
  saved.push_back(Json::object());
  Json wrong = saved[0];
  wrong["begin"] = "yesterday";
  saved.push_back(wrong);
  EventHistory history;
  history.load(saved, at(10));
  EXPECT_EQ(history.entries_json().size(), 1U);
  history.load("nothing", at(10));
  EXPECT_EQ(history.entries_json().size(), 1U);
}

}  // namespace
}  // namespace sslv::event_history_test
