// SPDX-License-Identifier: Apache-2.0
// The real daemon among other programs on the field's network: other visions and the game controller.
#include "e2e/running_daemon.h"
#include "net/packets.h"
#include "ssl_gc_referee_message.pb.h"

#include <algorithm>
#include <map>

#include <gmock/gmock.h>

namespace sslv::test::neighbours_test {
namespace {

using ::testing::IsEmpty;

class Neighbours : public DaemonTest {
 protected:
  Neighbours() {
    settings_["network"]["referee"] = {{"group", GroupListener::kGroup}, {"port", referee_group_.port()}};
  }

  void send_referee(const std::string& yellow, const std::string& blue, const std::string& source = "test") {
    Referee referee;
    referee.mutable_yellow()->set_name(yellow);
    referee.mutable_blue()->set_name(blue);
    referee.set_source_identifier(source);
    ASSERT_TRUE(send(game_controller_, referee.SerializeAsString()));
  }

  GroupListener referee_group_;
  MulticastSender game_controller_{settings_for(referee_group_)}, other_vision_{settings_for(listener_)};
};

std::vector<std::string> titles(const Json& status) {
  std::vector<std::string> titles;
  for (const Json& alert : status["alerts"]) titles.push_back(alert["title"]);
  return titles;
}

TEST_F(Neighbours, RobotsHaveTheHeightOfTheTeamThatTheGameControllerNames) {
  RunningDaemon daemon(settings_file(), state_);
  std::map<std::uint32_t, std::uint32_t> last_number;  // by camera
  const auto wait_for_heights = [&](float yellow_mm, float blue_mm) {
    bool yellow = false, blue = false;
    while (!(yellow && blue)) {
      const SSL_WrapperPacket packet = receive(listener_);
      if (!packet.has_detection()) continue;
      const SSL_DetectionFrame& frame = packet.detection();
      // The camera keeps running: it was not reopened.
      EXPECT_GE(frame.frame_number(), last_number[frame.camera_id()]);
      last_number[frame.camera_id()] = frame.frame_number();
      for (const auto& robot : frame.robots_yellow()) yellow |= robot.height() == yellow_mm;
      for (const auto& robot : frame.robots_blue()) blue |= robot.height() == blue_mm;
    }
  };
  wait_for_heights(140, 140);
  send_referee("tigers mannheim", "RobôCIn-B");
  wait_for_heights(143, 150);
  Json status =
      daemon.wait_for_status([](const Json& s) { return s["teams"]["blue"]["robot_height"] == 150; });
  EXPECT_EQ(status["teams"]["yellow"],
            (Json{{"name", "tigers mannheim"}, {"robot_height", 143.0}, {"height_from", "referee"}}));
  EXPECT_EQ(status["referee"]["source"], "test");
  EXPECT_THAT(titles(status), IsEmpty());

  // Data other than referee messages has no effect.
  send(game_controller_, "garbage");
  send(game_controller_, std::string(65'507, '\xFF'));
  status = daemon.wait_for_status([](const Json& s) { return s["referee"]["packets_refused"] == 2; });
  EXPECT_EQ(status["teams"]["yellow"]["robot_height"], 143.0);

  // An unknown team gets the height from the settings, and the operator is warned.
  send_referee("tigers mannheim", "Dire Wolves");
  wait_for_heights(143, 140);
  status = daemon.wait_for_status([](const Json& s) { return has_alert(s, "team_unknown"); });
  EXPECT_THAT(titles(status),
              testing::ElementsAre("Unknown team \"Dire Wolves\": its robots are assumed to be 140 mm high"));

  // A value set by hand overrides the game controller's; other settings keep those of the game controller.
  daemon.set("/teams/blue/robot_height", 147);
  wait_for_heights(143, 147);
  daemon.set("/teams/height_from_referee", false);
  wait_for_heights(140, 147);
  status = daemon.wait_for_status([](const Json& s) { return s["alerts"].empty(); });
  EXPECT_EQ(status["teams"]["yellow"]["height_from"], "settings");
  EXPECT_EQ(status["cameras"][0]["reconnects"], 0);
}

TEST_F(Neighbours, TheGameControllerIsNotHeardWhenThatIsOff) {
  settings_["network"]["referee"]["enabled"] = false;
  RunningDaemon daemon(settings_file(), state_);
  send_referee("MRL", "ibis");
  daemon.set("/network/referee/enabled", true);
  send_referee("KIKS", "The Bots");
  const Json status =
      daemon.wait_for_status([](const Json& s) { return s["teams"]["yellow"]["name"] != ""; });
  EXPECT_EQ(status["teams"]["yellow"]["name"], "KIKS");
  EXPECT_EQ(status["teams"]["blue"]["robot_height"], 110.0);
}

TEST_F(Neighbours, FollowsOneGameControllerAndWarnsOfASecond) {
  RunningDaemon daemon(settings_file(), state_);
  send_referee("MRL", "ibis");
  daemon.wait_for_status([](const Json& s) { return s["teams"]["yellow"]["name"] == "MRL"; });
  Json status = daemon.wait_for_status([&](const Json& s) {
    // In this order, so that after a pause on a busy computer the first one is followed again.
    send_referee("MRL", "ibis");
    send_referee("ibis", "MRL", "another");
    return has_alert(s, "two_game_controllers");
  });
  EXPECT_EQ(status["teams"]["yellow"]["name"], "MRL");
  EXPECT_EQ(status["referee"]["source"], "test");
  EXPECT_EQ(status["referee"]["other"], (Json{{"source", "another"}, {"address", "127.0.0.1"}}));
  EXPECT_THAT(titles(status), testing::ElementsAre("Two game controllers send: test at 127.0.0.1, which is "
                                                   "followed, and another at 127.0.0.1"));
  // The first falls silent: the second is followed, and the alert clears automatically.
  status = daemon.wait_for_status([&](const Json& s) {
    send_referee("ibis", "MRL", "another");
    return s["alerts"].empty() && s["referee"]["source"] == "another";
  });
  EXPECT_EQ(status["teams"]["yellow"]["name"], "ibis");
}

TEST_F(Neighbours, WarnsOfAnotherVisionUntilItIsSilent) {
  RunningDaemon daemon(settings_file(), state_);
  daemon.wait_for_status([](const Json& s) { return s["network"]["packets_sent"] > 50; });
  // The daemon's own packets do not count as another vision, even after its socket was reopened.
  daemon.set("/network/vision/ttl", 3);
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
  write_detection({.camera_id = 7, .number = 1, .times = {1}}, {}, {}, 2, packet);
  status = wait_for_title("127.0.0.1 also sends to the vision group");
  EXPECT_EQ(alert_of(status, "vision_other")["severity"], "info");
  EXPECT_EQ(status["network"]["other_visions"].at(0)["cameras"], Json{7});
  EXPECT_THAT(status["network"]["other_visions"].at(0)["field_conflicts"], IsEmpty());
  packet.mutable_detection()->set_camera_id(1);
  wait_for_title("Camera id 1 is also sent by 127.0.0.1");
  FieldSize theirs;
  theirs.field_length = 12000;
  theirs.goal_width = 1800;
  write_geometry({.field = theirs, .cameras = {}}, packet);
  status = wait_for_title(
      "127.0.0.1 sends another field: field_length is 9000 here and 12000 there, goal_width is "
      "1000 here and 1800 there");
  EXPECT_EQ(status["network"]["other_visions"].at(0)["field_conflicts"],
            Json::parse(R"([{"name": "field_length", "ours": 9000.0, "theirs": 12000.0},
                            {"name": "goal_width", "ours": 1000.0, "theirs": 1800.0}])"));

  const auto refused_before = status["network"]["packets_refused"].get<int>();
  send(other_vision_, "garbage");
  daemon.wait_for_status(
      [&](const Json& s) { return s["network"]["packets_refused"] == refused_before + 1; });
  // Nothing more is sent: the alerts clear automatically.
  status = daemon.wait_for_status([](const Json& s) { return s["alerts"].empty(); });
  EXPECT_THAT(status["network"]["other_visions"], IsEmpty());
}

}  // namespace
}  // namespace sslv::test::neighbours_test
