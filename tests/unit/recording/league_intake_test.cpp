// SPDX-License-Identifier: Apache-2.0
#include "recording/league_intake.h"

#include "ssl_gc_referee_message.pb.h"
#include "ssl_vision_wrapper.pb.h"
#include "ssl_vision_wrapper_tracked.pb.h"

#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <string>

#include <gtest/gtest.h>

namespace sslv::league_intake_test {
namespace {

constexpr std::int32_t kTypes[] = {LoggedMessage::kVision2014, LoggedMessage::kTracker2020,
                                   LoggedMessage::kReferee};

bool is_taken(std::int32_t type, const std::string& datagram) {
  return is_league_message(type, std::as_bytes(std::span(datagram)));
}

std::string detection() {
  SSL_WrapperPacket packet;
  auto* frame = packet.mutable_detection();
  frame->set_frame_number(1);
  frame->set_t_capture(1);
  frame->set_t_sent(1);
  frame->set_camera_id(0);
  return packet.SerializeAsString();
}

std::string geometry() {
  SSL_WrapperPacket packet;
  auto* field = packet.mutable_geometry()->mutable_field();
  field->set_field_length(9000);
  field->set_field_width(6000);
  field->set_goal_width(1000);
  field->set_goal_depth(180);
  field->set_boundary_width(300);
  return packet.SerializeAsString();
}

std::string tracked() {
  TrackerWrapperPacket packet;
  packet.set_uuid("a");
  packet.mutable_tracked_frame()->set_frame_number(1);
  packet.mutable_tracked_frame()->set_timestamp(1);
  return packet.SerializeAsString();
}

std::string referee() {
  Referee packet;
  packet.mutable_yellow()->set_name("");
  packet.mutable_blue()->set_name("TIGERs");
  return packet.SerializeAsString();
}

TEST(LeagueIntake, TakesWhatTheLeagueSendsToEachGroup) {
  EXPECT_TRUE(is_taken(LoggedMessage::kVision2014, detection()));
  EXPECT_TRUE(is_taken(LoggedMessage::kVision2014, geometry()));
  EXPECT_TRUE(is_taken(LoggedMessage::kTracker2020, tracked()));
  EXPECT_TRUE(is_taken(LoggedMessage::kReferee, referee()));
}

TEST(LeagueIntake, TakesSettingsOfAVisionProcessor) {
  const std::string settings{"\x22\x02hi"};  // field 4 of the wrapper
  EXPECT_TRUE(is_taken(LoggedMessage::kVision2014, settings));
  EXPECT_FALSE(is_taken(LoggedMessage::kVision2014, settings.substr(0, 3))) << "cut off";
  EXPECT_FALSE(is_taken(LoggedMessage::kVision2014, "\x2a\x02hi")) << "field 5";
}

TEST(LeagueIntake, LeavesOutTheRest) {
  EXPECT_FALSE(is_taken(LoggedMessage::kVision2014, tracked()));
  EXPECT_FALSE(is_taken(LoggedMessage::kTracker2020, detection()));
  EXPECT_FALSE(is_taken(LoggedMessage::kReferee, tracked()));
  EXPECT_FALSE(is_taken(1002, detection()));
  std::mt19937 chance(4);
  for (const std::int32_t type : kTypes) {
    EXPECT_FALSE(is_taken(type, "")) << type;
    EXPECT_FALSE(is_taken(type, "hello")) << type;
    for (int i = 0; i < 1000; ++i) {
      std::string noise(chance() % 1500 + 100, '\0');
      for (char& byte : noise) byte = static_cast<char>(chance());
      EXPECT_FALSE(is_taken(type, noise)) << type;
    }
  }
}

constexpr std::uint32_t kSender = 0x0a000001;

TEST(LeagueShare, IsLimitedAndRefills) {
  LeagueShare share(2000);
  std::size_t taken = 0;
  while (share.take(kSender, 100 - kMessageHeaderBytes, 50)) taken += 100;
  EXPECT_EQ(taken, 2000U) << "two seconds' at once";
  EXPECT_TRUE(share.take(kSender, 500 - kMessageHeaderBytes, 50.5));
  EXPECT_FALSE(share.take(kSender, 0, 50.5)) << "empty ones count, too";
  EXPECT_FALSE(share.take(kSender, 3000, 1000)) << "never more than two seconds' at once";
  for (double now_s = 1000; now_s < 1010; now_s += 0.01)
    taken += share.take(kSender, 100 - kMessageHeaderBytes, now_s) ? 100 : 0;
  EXPECT_NEAR(static_cast<double>(taken - 2000), 2000 + 10 * 1000, 150);
  while (share.take(kSender, 84, 1011)) {
  }
  EXPECT_FALSE(share.take(kSender, 84, 900)) << "a clock that goes back gives nothing";
  EXPECT_FALSE(share.take(kSender, 84, 1011)) << "nor one that goes on again";
}

TEST(LeagueShare, OneSenderLeavesHalfToTheOthers) {
  LeagueShare share(2000);
  while (share.take(kSender, 84, 50)) {
  }
  EXPECT_TRUE(share.take(kSender + 1, 84, 50));
  // However many senders there are, they never record more than the total limit.
  std::size_t taken = 0;
  for (std::uint32_t sender = 0; sender < 1000; ++sender) taken += share.take(sender, 84, 50) ? 100 : 0;
  EXPECT_EQ(taken, 1900U);
  EXPECT_TRUE(share.take(kSender, 84, 60)) << "it was forgotten, or has a new share";
}

}  // namespace
}  // namespace sslv::league_intake_test
