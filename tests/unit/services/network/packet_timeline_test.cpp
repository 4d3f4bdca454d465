// SPDX-License-Identifier: Apache-2.0
#include "services/network/packet_timeline.h"

#include <gmock/gmock.h>

namespace sslv::packet_timeline_test {
namespace {

TEST(PacketTimeline, KeepsTheRateOfEachSecondForTenMinutes) {
  PacketTimeline timeline;
  timeline.add(1000, 50);
  EXPECT_TRUE(timeline.to_json(600)["time_s"].empty()) << "a rate has two ends";
  timeline.add(1001, 110);
  timeline.add(1003, 210);
  EXPECT_EQ(timeline.to_json(600), Json({{"time_s", {1001.0, 1003.0}}, {"packets_per_s", {60.0, 50.0}}}));
  EXPECT_EQ(timeline.to_json(1), Json({{"time_s", {1003.0}}, {"packets_per_s", {50.0}}}));
  for (int i = 0; i < 700; ++i) timeline.add(1004 + i, 210);
  EXPECT_EQ(timeline.to_json(1000)["time_s"].size(), PacketTimeline::kSeconds);
}

TEST(PacketTimeline, HasNoRateAcrossAClockChange) {
  PacketTimeline timeline;
  timeline.add(1000, 0);
  timeline.add(5000, 60);
  timeline.add(4000, 120);
  EXPECT_TRUE(timeline.to_json(600)["time_s"].empty());
  timeline.add(4001, 180);
  EXPECT_EQ(timeline.to_json(600)["packets_per_s"], Json({60.0}));
}

}  // namespace
}  // namespace sslv::packet_timeline_test
