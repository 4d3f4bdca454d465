// SPDX-License-Identifier: Apache-2.0
#include "net/heard_packets.h"

#include "base/json.h"
#include "net/packets.h"
#include "ssl_vision_wrapper.pb.h"

#include <string>

#include <gmock/gmock.h>

namespace sslv::heard_packets_test {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

std::string detection_of(std::uint32_t camera_id, std::uint32_t number) {
  SSL_WrapperPacket packet;
  write_detection({.camera_id = camera_id, .number = number, .times = {1}}, {}, {}, 2, packet);
  return packet.SerializeAsString();
}

void hear(HeardPackets& heard, const std::string& datagram, double now_s) {
  heard.receive(std::as_bytes(std::span(datagram)), now_s);
}

TEST(HeardPackets, KeepsTheNewestOfEachCameraAndTheGeometry) {
  HeardPackets heard;
  EXPECT_THAT(heard.detections(100), IsEmpty());
  EXPECT_FALSE(heard.geometry(100));
  hear(heard, detection_of(0, 1), 100);
  hear(heard, detection_of(1, 7), 100);
  hear(heard, detection_of(0, 2), 100.5);
  hear(heard, "no packet", 100.5);
  SSL_WrapperPacket geometry;
  write_geometry({}, geometry);
  hear(heard, geometry.SerializeAsString(), 100.5);

  const auto detections = heard.detections(101);
  ASSERT_THAT(detections, SizeIs(2));
  EXPECT_EQ(detections.at(0).count, 2U);
  EXPECT_EQ(detections.at(0).heard_s, 100.5);
  EXPECT_EQ(Json::parse(packet_json(detections.at(0).bytes)).at("detection").at("frame_number"), 2);
  EXPECT_EQ(Json::parse(packet_json(detections.at(1).bytes)).at("detection").at("frame_number"), 7);
  ASSERT_TRUE(heard.geometry(101));
  EXPECT_EQ(
      Json::parse(packet_json(heard.geometry(101)->bytes)).at("geometry").at("field").at("field_length"),
      9000);

  heard.clear();
  EXPECT_THAT(heard.detections(101), IsEmpty());
  EXPECT_FALSE(heard.geometry(101));
}

TEST(HeardPackets, TellsTheRateOfTheLastSecondAndZeroInABreak) {
  HeardPackets heard;
  std::uint32_t number = 0;
  const auto hear_one = [&](double now_s) { hear(heard, detection_of(3, number++), now_s); };
  for (int i = 0; i <= 150; ++i) hear_one(100 + i / 50.0);
  EXPECT_NEAR(heard.detections(103).at(3).per_s, 50, 1);
  EXPECT_EQ(heard.detections(106).at(3).per_s, 0);
  hear_one(110);  // the rate is unknown after a break
  EXPECT_EQ(heard.detections(110).at(3).per_s, 0);
}

TEST(HeardPackets, ForgetsACameraThatIsGone) {
  HeardPackets heard;
  hear(heard, detection_of(0, 1), 100);
  hear(heard, detection_of(1, 1), 100);
  hear(heard, detection_of(1, 2), 150);
  const auto detections = heard.detections(170);
  ASSERT_THAT(detections, SizeIs(1));
  EXPECT_EQ(detections.begin()->first, 1U);
}

TEST(PacketJson, HasTheNamesOfTheMessagesAndOnlyWhatThePacketHas) {
  SSL_WrapperPacket packet;
  SSL_DetectionFrame& frame = *packet.mutable_detection();
  frame.set_frame_number(5);
  frame.set_t_capture(1.5);
  frame.set_t_sent(1.75);
  frame.set_camera_id(2);
  SSL_DetectionRobot& robot = *frame.add_robots_blue();
  robot.set_confidence(0.5);
  robot.set_robot_id(0);
  robot.set_x(-12.5);
  robot.set_y(0);
  robot.set_pixel_x(1);
  robot.set_pixel_y(2);
  const std::string bytes = packet.SerializeAsString();
  EXPECT_EQ(Json::parse(packet_json(std::as_bytes(std::span(bytes)))), (Json{{"detection",
                                                                              {{"frame_number", 5},
                                                                               {"t_capture", 1.5},
                                                                               {"t_sent", 1.75},
                                                                               {"camera_id", 2},
                                                                               {"robots_blue",
                                                                                {{{"confidence", 0.5},
                                                                                  {"robot_id", 0},
                                                                                  {"x", -12.5},
                                                                                  {"y", 0},
                                                                                  {"pixel_x", 1},
                                                                                  {"pixel_y", 2}}}}}}}));
  EXPECT_EQ(packet_json(std::as_bytes(std::span("\xff"))), "");
}

}  // namespace
}  // namespace sslv::heard_packets_test
