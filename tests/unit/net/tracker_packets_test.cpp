// SPDX-License-Identifier: Apache-2.0
#include "net/tracker_packets.h"

#include <gmock/gmock.h>

namespace sslv::tracker_packets_test {
namespace {

TrackedField field() {
  TrackedField out;
  out.number = 12;
  out.t_s = 1000.5;
  TrackedRobot robot;
  robot.name = {Team::kBlue, 7};
  robot.place_mm = {1000, -2000};
  robot.velocity_mm_s = {300, 400};
  robot.orientation_rad = 1.5;
  robot.turn_rad_s = -2;
  robot.visibility = 0.5;
  out.robots.push_back(robot);
  TrackedBall ball;
  ball.place_mm = {500, 600, 700};
  ball.velocity_mm_s = {1000, 0, -100};
  ball.visibility = 1;
  out.balls.push_back(ball);
  TrackedKick kick;
  kick.number = 1;
  kick.t_s = 1000.2;
  kick.place_mm = {200, 600};
  kick.velocity_mm_s = {4000, 0, 3000};
  kick.stop_s = 1004;
  kick.stop_mm = {5000, 600};
  kick.robot = RobotName{Team::kYellow, 3};
  out.kick = kick;
  return out;
}

TEST(TrackerPackets, AreInMetersAndSayWhatTheSourceCanTell) {
  TrackerWrapperPacket packet;
  write_tracked(field(), {"an-id", "us"}, packet);
  EXPECT_EQ(packet.uuid(), "an-id");
  EXPECT_EQ(packet.source_name(), "us");
  const TrackedFrame& frame = packet.tracked_frame();
  EXPECT_EQ(frame.frame_number(), 12U);
  EXPECT_EQ(frame.timestamp(), 1000.5);
  ASSERT_EQ(frame.robots_size(), 1);
  EXPECT_EQ(frame.robots(0).robot_id().id(), 7U);
  EXPECT_EQ(frame.robots(0).robot_id().team(), ::BLUE);
  EXPECT_FLOAT_EQ(frame.robots(0).pos().x(), 1);
  EXPECT_FLOAT_EQ(frame.robots(0).pos().y(), -2);
  EXPECT_FLOAT_EQ(frame.robots(0).vel().y(), 0.4F);
  EXPECT_FLOAT_EQ(frame.robots(0).orientation(), 1.5F);
  EXPECT_FLOAT_EQ(frame.robots(0).vel_angular(), -2);
  EXPECT_FLOAT_EQ(frame.robots(0).visibility(), 0.5F);
  ASSERT_EQ(frame.balls_size(), 1);
  EXPECT_FLOAT_EQ(frame.balls(0).pos().z(), 0.7F);
  EXPECT_FLOAT_EQ(frame.balls(0).vel().z(), -0.1F);
  EXPECT_EQ(frame.kicked_ball().start_timestamp(), 1000.2);
  EXPECT_FLOAT_EQ(frame.kicked_ball().pos().x(), 0.2F);
  EXPECT_EQ(frame.kicked_ball().stop_timestamp(), 1004);
  EXPECT_FLOAT_EQ(frame.kicked_ball().stop_pos().x(), 5);
  EXPECT_FLOAT_EQ(frame.kicked_ball().vel().z(), 3);
  EXPECT_EQ(frame.kicked_ball().robot_id().team(), ::YELLOW);
  EXPECT_THAT(frame.capabilities(),
              testing::UnorderedElementsAre(CAPABILITY_DETECT_FLYING_BALLS, CAPABILITY_DETECT_MULTIPLE_BALLS,
                                            CAPABILITY_DETECT_KICKED_BALLS));
}

TEST(TrackerPackets, AKickIsSentWhileItsBallMoves) {
  TrackedField tracked = field();
  TrackerWrapperPacket packet;
  write_tracked(tracked, {}, packet);
  EXPECT_TRUE(packet.tracked_frame().has_kicked_ball());
  tracked.balls[0].velocity_mm_s.setZero();
  write_tracked(tracked, {}, packet);
  EXPECT_FALSE(packet.tracked_frame().has_kicked_ball());
  EXPECT_EQ(packet.tracked_frame().robots_size(), 1)
      << "a message that is used again holds nothing of before";
  EXPECT_EQ(packet.tracked_frame().capabilities_size(), 3);
}

TEST(TrackerPackets, HaveTheLeaguesEncoding) {
  TrackedField tracked;
  tracked.number = 1;
  tracked.t_s = 2;
  TrackerWrapperPacket packet;
  std::vector<std::byte> buffer;
  write_tracked(tracked, {"u", "n"}, packet);
  const auto bytes = serialize(packet, buffer);
  // Encoded by hand: uuid 1, source_name 2, tracked_frame 3 {frame_number 1, timestamp 2, capabilities 6}.
  const std::string expected{
      "\x0a\x01u\x12\x01n\x1a\x11\x08\x01\x11\x00\x00\x00\x00\x00\x00\x00\x40"
      "\x30\x01\x30\x02\x30\x03",
      25};
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()), expected);
}

}  // namespace
}  // namespace sslv::tracker_packets_test
