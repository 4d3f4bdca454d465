// SPDX-License-Identifier: Apache-2.0
#include "health/timeline.h"

#include <gtest/gtest.h>

namespace sslv::timeline_test {
namespace {

Timeline::Reading running(std::uint64_t frames, std::uint64_t dropped = 0) {
  return {.is_running = true,
          .fps = 60,
          .times = Timeline::Reading::Times{0.5, 0.9, 3.0},
          .robots = 6,
          .balls = 1,
          .frames = frames,
          .dropped = dropped};
}

TEST(Timeline, CountsByTheSecondWhatCamerasCountFromTheirStart) {
  Timeline timeline;
  timeline.add(100, 100, {{0, running(1000, 7)}});
  timeline.add(101, 101, {{0, running(1060, 7)}});
  timeline.add(102, 102, {{0, running(1117, 10)}});
  const Json json = timeline.to_json();
  EXPECT_EQ(json["time_s"], Json({100, 101, 102}));
  EXPECT_EQ(json["cameras"][0]["id"], 0);
  EXPECT_EQ(json["cameras"][0]["dropped"], Json({nullptr, 0, 3}));
  EXPECT_EQ(json["cameras"][0]["latency_p99_ms"], Json({nullptr, 0.9, 0.9}));
  EXPECT_EQ(timeline.sum(0, 60).frames, 117u);
  EXPECT_EQ(timeline.sum(0, 60).dropped, 3u);
  EXPECT_EQ(timeline.sum(0, 1).frames, 57u);
  EXPECT_EQ(timeline.sum(9, 60).seconds, 0u);
}

TEST(Timeline, FollowsOnlyClockChanges) {
  Timeline timeline;
  timeline.add(5000, 100, {});
  timeline.add(5001.001, 101, {});
  EXPECT_EQ(timeline.to_json()["time_s"], Json({5000.0, 5001.0})) << "a second keeps its time";
  timeline.add(8602, 102, {});
  EXPECT_EQ(timeline.to_json()["time_s"], Json({8600.0, 8601.0, 8602.0}));
  timeline.add(5003, 103, {});
  EXPECT_EQ(timeline.to_json()["time_s"], Json({5000.0, 5001.0, 5002.0, 5003.0}));
}

TEST(Timeline, HasNothingOfSecondsInWhichACameraDidNotRun) {
  Timeline timeline;
  timeline.add(100, 100, {{0, running(0)}});
  timeline.add(101, 101, {{0, Timeline::Reading{}}});
  timeline.add(102, 102, {{0, running(40)}});
  timeline.add(103, 103, {{0, running(100)}});
  EXPECT_EQ(timeline.to_json()["cameras"][0]["fps"], Json({nullptr, nullptr, nullptr, 60.0}));
  EXPECT_EQ(timeline.sum(0, 60).seconds, 1u);
  EXPECT_EQ(timeline.sum(0, 60).frames, 60u);
}

TEST(Timeline, HasNoTimesOfASecondWithoutAFrame) {
  Timeline timeline;
  timeline.add(100, 100, {{0, running(5)}});
  Timeline::Reading silent = running(5);
  silent.times = std::nullopt;
  timeline.add(101, 101, {{0, silent}});
  const Json json = timeline.to_json(1);
  EXPECT_EQ(json["cameras"][0]["age_p99_ms"], Json::array({nullptr}));
  EXPECT_EQ(json["cameras"][0]["robots"], Json::array({6}));
}

TEST(Timeline, ContinuesWhenACamerasCountersRestart) {
  Timeline timeline;
  timeline.add(100, 100, {{0, running(1000)}});
  timeline.add(101, 101, {{0, running(20)}});
  EXPECT_EQ(timeline.sum(0, 60).frames, 20u);
}

TEST(Timeline, KeepsTenMinutesOfTheCamerasThatAreThere) {
  Timeline timeline;
  for (unsigned i = 0; i < 700; ++i) timeline.add(i, i, {{0, running(i)}});
  for (unsigned i = 700; i < 710; ++i) timeline.add(i, i, {{0, running(i)}, {3, running(i)}});
  const Json json = timeline.to_json();
  EXPECT_EQ(json["time_s"].size(), 600u);
  EXPECT_EQ(json["time_s"].back(), 709);
  ASSERT_EQ(json["cameras"].size(), 2u);
  for (const Json& camera : json["cameras"]) {
    for (const auto& [name, values] : camera.items()) {
      if (name != "id") {
        EXPECT_EQ(values.size(), 600u) << name;
      }
    }
  }
  EXPECT_EQ(timeline.to_json(5)["cameras"][1]["fps"].size(), 5u);
  timeline.add(710, 710, {{3, running(710)}});
  EXPECT_EQ(timeline.to_json()["cameras"].size(), 1u);
}

}  // namespace
}  // namespace sslv::timeline_test
