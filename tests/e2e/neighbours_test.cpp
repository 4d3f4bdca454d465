// SPDX-License-Identifier: Apache-2.0
// The real daemon among other programs of the field's network: other visions.
#include "e2e/running_daemon.h"
#include "net/multicast.h"
#include "net/packets.h"

#include <algorithm>

#include <gmock/gmock.h>

namespace sslv::test {
namespace {

using ::testing::IsEmpty;

MulticastSettings group_of(const GroupListener& listener) {
  MulticastSettings settings;
  settings.group = GroupListener::kGroup;
  settings.port = listener.port();
  settings.interface = "lo";
  return settings;
}

class Neighbours : public ::testing::Test {
 protected:
  Neighbours() { folder_.write("settings.json", settings_.dump(2)); }

  void send(MulticastSender& sender, const std::string& datagram) {
    ASSERT_TRUE(sender.send(std::as_bytes(std::span(datagram))));
  }
  std::string settings_file() const { return (folder_.path() / "settings.json").string(); }

  GroupListener listener_;
  MulticastSender other_vision_{group_of(listener_)};
  TemporaryFolder folder_;
  Json settings_ = demo_settings(listener_.port());
  std::filesystem::path state_ = folder_.path() / "state";
};

std::vector<std::string> titles(const Json& status) {
  std::vector<std::string> titles;
  for (const Json& alert : status["alerts"]) titles.push_back(alert["title"]);
  return titles;
}

TEST_F(Neighbours, WarnsOfAnotherVisionUntilItIsSilent) {
  RunningDaemon daemon(settings_file(), state_);
  daemon.wait_for_status([](const Json& s) { return s["network"]["packets_sent"] > 50; });
  // The daemon's own packets are no other vision's, also when its socket was opened anew.
  daemon.patch(Json::parse(R"([{"op": "replace", "path": "/network/vision/ttl", "value": 3}])"));
  Json status = daemon.wait_for_status([](const Json& s) { return s["network"]["packets_sent"] > 150; });
  EXPECT_THAT(status["alerts"], IsEmpty());
  EXPECT_THAT(status["network"]["other_visions"], IsEmpty());

  SSL_WrapperPacket packet;
  const auto send_packet = [&] { send(other_vision_, packet.SerializeAsString()); };
  const auto wait_for_title = [&](const std::string& part) {
    return daemon.wait_for_status([&](const Json& s) {
      send_packet();
      const auto all = titles(s);
      return std::any_of(all.begin(), all.end(),
                         [&](const std::string& title) { return title.find(part) != std::string::npos; });
    });
  };
  write_detection({.camera_id = 7, .number = 1, .t_capture_s = 1}, {}, {}, 2, packet);
  status = wait_for_title("127.0.0.1 sends to the vision group too");
  EXPECT_EQ(status["alerts"][0]["severity"], "info");
  EXPECT_EQ(status["network"]["other_visions"][0]["cameras"], Json{7});
  packet.mutable_detection()->set_camera_id(1);
  wait_for_title("Camera id 1 is also sent by 127.0.0.1");
  FieldSize theirs;
  theirs.field_length = 12000;
  theirs.goal_width = 1800;
  write_geometry({.field = theirs, .cameras = {}}, packet);
  status = wait_for_title(
      "127.0.0.1 sends another field: field_length is 9000 here and 12000 there, goal_width is "
      "1000 here and 1800 there");

  const auto refused_before = status["network"]["packets_refused"].get<int>();
  send(other_vision_, "garbage");
  daemon.wait_for_status(
      [&](const Json& s) { return s["network"]["packets_refused"] == refused_before + 1; });
  // Nothing more is sent: the alerts go by themselves.
  status = daemon.wait_for_status([](const Json& s) { return s["alerts"].empty(); });
  EXPECT_THAT(status["network"]["other_visions"], IsEmpty());
}

}  // namespace
}  // namespace sslv::test
