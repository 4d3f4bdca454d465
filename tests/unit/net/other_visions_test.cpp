// SPDX-License-Identifier: Apache-2.0
#include "net/other_visions.h"

#include "base/clock.h"
#include "net/packets.h"
#include "support/becomes.h"
#include "support/group_listener.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>

namespace sslv::other_visions_test {
namespace {

using boost::asio::ip::udp;
using testing::ElementsAre;
using testing::IsEmpty;

udp::endpoint from(const char* address, std::uint16_t port = 40'000) {
  return {boost::asio::ip::make_address(address), port};
}

SSL_WrapperPacket detection(std::uint32_t camera_id) {
  SSL_WrapperPacket packet;
  write_detection({.camera_id = camera_id, .number = 1, .times = {1}}, {}, {}, 2, packet);
  return packet;
}

SSL_WrapperPacket geometry(const FieldSize& field) {
  SSL_WrapperPacket packet;
  write_geometry({.field = field, .cameras = {}}, packet);
  return packet;
}

struct Group {
  OtherVisions others{[](const udp::endpoint& sender) { return sender == from("10.0.0.1"); }};
  void receive(const std::string& datagram, const udp::endpoint& sender, double now_s = 100) {
    others.receive(std::as_bytes(std::span(datagram)), sender, now_s);
  }
  void receive(const SSL_WrapperPacket& packet, const udp::endpoint& sender, double now_s = 100) {
    receive(packet.SerializePartialAsString(), sender, now_s);
  }
};

TEST(OtherVisions, TellsWhoSendsWithWhichCameras) {
  Group group;
  group.receive(detection(3), from("10.0.0.2"), 100);
  group.receive(detection(1), from("10.0.0.2", 40'001), 101);
  group.receive(detection(0), from("10.0.0.1"), 101);  // this daemon
  group.receive(geometry({}), from("10.0.0.3"), 102);
  const auto seen = group.others.seen(103);
  ASSERT_EQ(seen.size(), 2U);
  EXPECT_EQ(seen[0].address, "10.0.0.2");
  EXPECT_THAT(seen[0].cameras, ElementsAre(1, 3));
  EXPECT_EQ(seen[0].silent_s, 2);
  EXPECT_FALSE(seen[0].field);
  EXPECT_EQ(seen[1].address, "10.0.0.3");
  EXPECT_THAT(seen[1].cameras, IsEmpty());
  ASSERT_TRUE(seen[1].field);
  EXPECT_EQ(seen[1].field->field_length(), 9000);
  EXPECT_EQ(seen[1].field->field_lines_size(), 0);
}

TEST(OtherVisions, ForgetsWhoIsSilentForFiveSeconds) {
  Group group;
  group.receive(detection(1), from("10.0.0.2"), 100);
  group.receive(detection(2), from("10.0.0.2"), 103);
  EXPECT_THAT(group.others.seen(105).at(0).cameras, ElementsAre(1, 2));
  EXPECT_THAT(group.others.seen(106).at(0).cameras, ElementsAre(2));
  EXPECT_THAT(group.others.seen(108.5), IsEmpty());
}

TEST(OtherVisions, NamesEverySizeThatDiffers) {
  FieldSize theirs;
  theirs.field_length = 12000;
  theirs.boundary_width_goal_line = 600;
  theirs.ball_radius = 21;
  theirs.goal_substitution_area_width = 500;  // ours has none
  FieldSize ours;
  ours.goal_substitution_area_width = 0;
  SSL_WrapperPacket packet = geometry(theirs);
  packet.mutable_geometry()->mutable_field()->clear_goal_height();
  std::map<std::string, std::pair<double, double>> conflicts;
  for (const SizeConflict& one :
       size_conflicts(geometry(ours).geometry().field(), packet.geometry().field())) {
    conflicts[one.name] = {one.ours, one.theirs};
  }
  const std::map<std::string, std::pair<double, double>> expected{
      {"field_length", {9000, 12000}}, {"boundary_width_goal_line", {300, 600}}, {"ball_radius", {21.5, 21}}};
  EXPECT_EQ(conflicts, expected);
}

TEST(OtherVisions, InvalidPacketsAreOnlyCounted) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  Group group;
  const std::string good = detection(1).SerializeAsString();
  std::vector<std::string> refused{"", "garbage", std::string(65'507, '\xFF'), std::string(65'507, '\0'),
                                   good.substr(0, good.size() - 3)};
  SSL_WrapperPacket packet;
  packet.set_source(SSL_SOURCE_OTHER);  // and nothing else
  refused.push_back(packet.SerializeAsString());
  packet = detection(1);
  packet.mutable_detection()->set_t_capture(kNan);
  refused.push_back(packet.SerializeAsString());
  write_detection({}, {}, {{Ball{kNan, 0, 0, 0, 40, 1}}}, 2, packet);
  refused.push_back(packet.SerializeAsString());
  refused.push_back(detection(256).SerializeAsString());
  packet = geometry({});
  packet.mutable_geometry()->mutable_field()->set_ball_radius(kNan);
  refused.push_back(packet.SerializeAsString());
  packet = geometry({});
  packet.mutable_geometry()->mutable_field()->set_field_length(-9000);
  refused.push_back(packet.SerializeAsString());
  packet = geometry({});
  packet.mutable_geometry()->mutable_field()->set_goal_width(std::numeric_limits<int>::max());
  refused.push_back(packet.SerializeAsString());
  testing::internal::CaptureStderr();
  for (const std::string& datagram : refused) group.receive(datagram, from("10.0.0.2"));
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "strangers do not fill the log";
  EXPECT_THAT(group.others.seen(100), IsEmpty());
  EXPECT_EQ(group.others.refused(), refused.size());
  group.receive(good, from("10.0.0.2"));
  EXPECT_EQ(group.others.seen(100).size(), 1U);
}

TEST(OtherVisions, SaysWhichComputersTheSettingsName) {
  Group group;
  group.others.set_named({"10.0.0.3"});
  group.receive(detection(1), from("10.0.0.2"));
  group.receive(detection(2), from("10.0.0.3"));
  EXPECT_FALSE(group.others.seen(100).at(0).is_named);
  EXPECT_TRUE(group.others.seen(100).at(1).is_named);
  group.others.set_named({"10.0.0.2"});
  EXPECT_TRUE(group.others.seen(100).at(0).is_named);
  EXPECT_FALSE(group.others.seen(100).at(1).is_named);
}

TEST(OtherVisions, StrangersDoNotDisplaceNamedComputers) {
  Group group;
  for (std::uint32_t i = 0; i < 300; ++i)
    group.receive(detection(1), {boost::asio::ip::address_v4(0x0A010000 + i), 1});
  group.others.set_named({"10.0.0.3"});
  group.receive(detection(2), from("10.0.0.3"));
  const auto seen = group.others.seen(100);
  EXPECT_THAT(seen, testing::Contains(testing::Field(&OtherVision::is_named, true)));
  EXPECT_LE(seen.size(), 17U);
}

TEST(OtherVisions, UnknownFieldsAreIgnored) {
  Group group;
  SSL_WrapperPacket packet = detection(3);
  // The league's programs have sent these since 2026: times in a detection (9), and a message of its own (4).
  packet.mutable_detection()->mutable_unknown_fields()->AddFixed64(9, 7);
  group.receive(packet, from("10.0.0.2"));
  SSL_WrapperPacket own;
  own.mutable_unknown_fields()->AddLengthDelimited(4, "whatever it is");
  group.receive(own, from("10.0.0.3"));
  EXPECT_EQ(group.others.refused(), 0U);
  ASSERT_EQ(group.others.seen(100).size(), 2U);
  EXPECT_THAT(group.others.seen(100)[0].cameras, ElementsAre(3));
  EXPECT_THAT(group.others.seen(100)[1].cameras, IsEmpty());
}

TEST(OtherVisions, AFloodOfSendersAndCamerasIsNotKept) {
  Group group;
  for (std::uint32_t i = 0; i < 3000; ++i) {
    group.receive(detection(i), {boost::asio::ip::address_v4(0x0A010000 + i % 300), 1});
  }
  const auto seen = group.others.seen(100);
  EXPECT_LE(seen.size(), 16U);
  for (const OtherVision& one : seen) EXPECT_LE(one.cameras.size(), 32U);
}

TEST(OtherVisions, HearsTheGroupAndNotItself) {
  GroupListener listener;
  const MulticastSettings settings = settings_for(listener);
  MulticastSender self(settings), other(settings);
  OtherVisions others([&](const udp::endpoint& sender) { return self.is_own(sender); });
  others.listen({settings.group, settings.port, settings.interface});
  const auto send = [](MulticastSender& sender, std::uint32_t camera_id) {
    std::vector<std::byte> buffer;
    EXPECT_TRUE(sender.send(serialize(detection(camera_id), buffer)));
  };
  send(self, 1);
  self.configure(settings);  // reopens the socket
  send(self, 2);
  std::vector<OtherVision> seen;
  EXPECT_TRUE(test::becomes([&] {
    send(other, 3);  // repeatedly: a sender silent for 5 s is forgotten
    seen = others.seen(steady_s());
    return !seen.empty();
  }));
  ASSERT_EQ(seen.size(), 1U);
  EXPECT_EQ(seen[0].address, "127.0.0.1");
  EXPECT_THAT(seen[0].cameras, ElementsAre(3));
  EXPECT_EQ(others.refused(), 0U);
}

}  // namespace
}  // namespace sslv::other_visions_test
