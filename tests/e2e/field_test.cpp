// SPDX-License-Identifier: Apache-2.0
// The real daemon's tracks: from the simulated pixels of two cameras to the packet, and with cameras of
// another computer.
#include "capture/simulator/simulator_world.h"
#include "config/config.h"
#include "e2e/running_daemon.h"
#include "lab/track_score.h"
#include "net/packets.h"
#include "ssl_vision_wrapper_tracked.pb.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

namespace sslv::test::field_test {
namespace {

using ::testing::HasSubstr;

class Field : public DaemonTest {
 protected:
  Field() {
    settings_["network"]["tracker"] = {{"enabled", true},
                                       {"group", GroupListener::kGroup},
                                       {"port", tracks_.port()},
                                       {"source_name", "field test"}};
  }

  TrackerWrapperPacket receive_tracks() {
    const auto datagram = tracks_.receive();
    TrackerWrapperPacket packet;
    if (!datagram || !packet.ParseFromString(*datagram)) throw std::runtime_error("no tracks came");
    return packet;
  }
  /// Waits for tracks that satisfy `good`; throws on timeout.
  template <class Good>
  TrackerWrapperPacket wait_for_tracks(Good good) {
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    for (;;) {
      TrackerWrapperPacket packet = receive_tracks();
      if (good(packet.tracked_frame())) return packet;
      if (std::chrono::steady_clock::now() > deadline)
        throw std::runtime_error("tracks never were so: " + packet.ShortDebugString());
    }
  }

  GroupListener tracks_;
};

TEST_F(Field, TracksAreWhereTheRobotsAreAlthoughCamerasDiffer) {
  make_images_small(settings_, 30);
  for (Json& camera : settings_["cameras"]) camera["source"]["speed"] = 0.5;
  // The cameras are displaced from their calibrations, are not synchronised, and have inexact times.
  settings_["cameras"][0]["source"]["errors"] = {{"moved_x_mm", -1.5}, {"time_jitter_ms", 0.2}};
  settings_["cameras"][1]["source"]["errors"] = {{"moved_x_mm", 1.5},
                                                 {"phase", 0.4},
                                                 {"time_offset_ms", 0.4},
                                                 {"time_jitter_ms", 0.2},
                                                 {"drop_share", 0.02}};
  const Config config = read_config(settings_);
  const SimulatedWorld world = simulated_world(config);
  RunningDaemon daemon(settings_file(), state_);

  const TrackerWrapperPacket first = receive_tracks();
  EXPECT_EQ(first.source_name(), "field test");
  EXPECT_THAT(first.tracked_frame().capabilities(), ::testing::SizeIs(3));
  // Once the clocks are aligned and no other load disturbs the test, 300 packets must be within all limits.
  // No ghost is allowed at any time.
  const auto are_good = [&](TrackScorer& scorer) {
    for (int i = 0; i < 300; ++i) {
      const TrackerWrapperPacket packet = receive_tracks();
      EXPECT_EQ(packet.uuid(), first.uuid());
      scorer.add(packet.tracked_frame(), unix_now_s());
    }
    EXPECT_EQ(scorer.ghosts(), 0U);
    const auto is_below = [&](const char* what, double most) {
      const auto known = scorer.errors().find(what);
      return known != scorer.errors().end() && known->second.quantile(0.5) < most;
    };
    return static_cast<double>(scorer.robots_missing()) <
               0.02 * static_cast<double>(scorer.robots_expected()) &&
           is_below("robot's place mm", 4) && is_below("robot's velocity mm/s", 60) &&
           is_below("robot's orientation deg", 2) && is_below("robot's jump mm", 1) &&
           is_below("ball's place mm", 5);
  };
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  for (bool is_good = false; !is_good && !HasFailure();) {
    TrackScorer scorer(world);
    is_good = are_good(scorer);
    ASSERT_TRUE(is_good || std::chrono::steady_clock::now() < deadline) << track_score_text(scorer);
  }

  const Json agreement = daemon.wait_for("/api/field/agreement", [](const Json& answer) {
    return answer.at("cameras").size() == 2 && answer.at("differences").size() > 3;
  });
  const Json field =
      daemon.wait_for("/api/field", [](const Json& answer) { return answer.at("robots").size() == 12; });
  EXPECT_EQ(field.at("source").at("uuid"), first.uuid());
  EXPECT_EQ(field.at("stages").size(), 5U);
  EXPECT_EQ(field.at("sends"), true);
}

TEST_F(Field, ACameraOfAnotherComputerIsShownAndTrackedOnceItIsNamed) {
  Json other = settings_;
  other["cameras"].erase(0);
  other["network"]["tracker"]["enabled"] = false;
  const std::string other_file = folder_.write("other.json", other.dump(2));
  settings_["cameras"].erase(1);
  const auto robots = [](const TrackedFrame& frame) {
    std::set<std::pair<int, unsigned>> names;
    for (const auto& robot : frame.robots()) names.emplace(robot.robot_id().team(), robot.robot_id().id());
    return names.size();
  };
  RunningDaemon daemon(settings_file(), state_);
  wait_for_tracks([&](const TrackedFrame& frame) { return robots(frame) > 0; });
  std::optional<RunningDaemon> second(std::in_place, other_file, folder_.path() / "other state");
  Json field = daemon.wait_for("/api/field", [](const Json& answer) {
    return answer.at("other_cameras").size() == 1 && answer["other_cameras"][0].at("robots") > 0;
  });
  EXPECT_EQ(field.at("other_cameras")[0].at("camera"), 1);
  EXPECT_EQ(field.at("other_cameras")[0].at("is_used"), false);
  Json status = daemon.wait_for_status([](const Json& s) { return has_alert(s, "vision_other"); });
  EXPECT_EQ(status["network"]["other_visions"].at(0).at("is_named"), false);
  // None of its detections were used so far: this computer's camera does not see all robots.
  const double shown_s = unix_now_s();
  wait_for_tracks([&](const TrackedFrame& frame) {
    EXPECT_LT(robots(frame), 12U);
    return frame.timestamp() > shown_s;
  });

  daemon.set("/field/other_computers", Json::array({"127.0.0.1"}));
  wait_for_tracks([&](const TrackedFrame& frame) { return robots(frame) == 12; });
  field = daemon.wait_for("/api/field", [](const Json& answer) {
    return answer.at("other_cameras").size() == 1 && answer["other_cameras"][0].at("is_used") == true;
  });
  status = daemon.wait_for_status([](const Json& s) { return !has_alert(s, "vision_other"); });
  EXPECT_EQ(status["network"]["other_visions"].at(0).at("is_named"), true);

  // The other computer vanishes: its robots disappear, and those that this computer sees remain.
  second.reset();
  daemon.wait_for("/api/field", [](const Json& answer) { return answer.at("other_cameras").empty(); });
  const double vanished_s = unix_now_s();
  wait_for_tracks([&](const TrackedFrame& frame) {
    return frame.timestamp() > vanished_s && robots(frame) > 0 && robots(frame) < 12;
  });

  daemon.set("/field/other_computers", Json::array());
  RunningDaemon again(other_file, folder_.path() / "other state");
  field =
      daemon.wait_for("/api/field", [](const Json& answer) { return !answer.at("other_cameras").empty(); });
  EXPECT_EQ(field.at("other_cameras")[0].at("is_used"), false);
}

/// Like a switch without IGMP: multicast is lost, broadcasts arrive.
TEST_F(Field, ABroadcastingComputerIsHeard) {
  Json other = settings_;
  other["cameras"].erase(0);
  other["network"]["tracker"]["enabled"] = false;
  other["network"]["vision"]["group"] = "127.255.255.255";
  const std::string other_file = folder_.write("other.json", other.dump(2));
  settings_["cameras"].erase(1);
  settings_["field"]["other_computers"] = Json::array({"127.0.0.1"});
  settings_["network"]["vision"]["broadcast"] = "127.255.255.255";
  RunningDaemon daemon(settings_file(), state_);
  RunningDaemon second(other_file, folder_.path() / "other state");
  daemon.wait_for("/api/field", [](const Json& answer) {
    return answer.at("other_cameras").size() == 1 && answer.at("robots").size() == 12;
  });
  // A packet that arrives by multicast and by broadcast counts once.
  const Json packets = daemon.wait_for("/api/network/packets", [](const Json& answer) {
    return !answer.at("detections").empty() && answer.at("arrivals").size() == 1 &&
           answer["arrivals"][0].at("multicast") == true;
  });
  EXPECT_EQ(packets.at("broadcast"), "127.255.255.255");
  EXPECT_EQ(packets["arrivals"][0],
            (Json{{"what", "vision"}, {"address", "127.0.0.1"}, {"multicast", true}, {"broadcast", true}}));
  const Json& heard = packets["detections"][0];
  EXPECT_LE(heard.at("packets").get<std::uint64_t>(),
            heard.at("packet").at("detection").at("frame_number").get<std::uint64_t>() + 1);
  // Teams receive it by multicast and by broadcast.
  while (!receive(listener_).has_detection()) {
  }
}

TEST_F(Field, ItsStackIsCheckedAndChangedWhileItRuns) {
  RunningDaemon daemon(settings_file(), state_);
  const std::string uuid = receive_tracks().uuid();
  EXPECT_THAT(
      daemon.set("/field/stack", {"gather", "track"}, 422).at("error"),
      HasSubstr("/field/stack/1: stage 'track' needs 'observations', which no earlier stage provides"));
  EXPECT_THAT(daemon.set("/field/stages/gather/max_time_off_s", -1, 422).at("error"),
              HasSubstr("/field/stages/gather/max_time_off_s"));
  const double refused_s = unix_now_s();
  wait_for_tracks([&](const TrackedFrame& frame) { return frame.timestamp() > refused_s; });
  daemon.set("/field/stack", Json::array());
  daemon.wait_for("/api/field", [](const Json& answer) { return answer.at("stages").empty(); });
  // The last tracks are not shown as if they were current.
  daemon.wait_for("/api/field", [](const Json& answer) { return answer.at("robots").empty(); });
  daemon.set("/field/stack", {"gather", "clocks", "agreement", "track", "publish"});
  const double since_s = unix_now_s();
  wait_for_tracks([&](const TrackedFrame& frame) { return frame.timestamp() > since_s; });
  daemon.set("/network/tracker/source_name", "another name");
  TrackerWrapperPacket packet = receive_tracks();
  while (packet.source_name() != "another name") packet = receive_tracks();
  EXPECT_EQ(packet.uuid(), uuid);
  daemon.set("/network/tracker/enabled", false);
  EXPECT_EQ(daemon.get("/api/field").at("sends"), false);
  // From the next image on nothing is sent, even though tracking continues.
  const auto after_images = [&](int images) {
    const int enough = daemon.get("/api/field").at("frames").get<int>() + images;
    return daemon.wait_for("/api/field", [&](const Json& field) { return field.at("frames") >= enough; });
  };
  const Json off = after_images(2);
  EXPECT_EQ(after_images(10).at("packets_sent"), off.at("packets_sent"));
}

/// Other computers' cameras send nonsense, always at least a metre from our robots. Our cameras see the whole
/// field and standing robots, so any motion of a track comes from the foreign data. Tracks are compared only
/// while our cameras deliver images: if a busy computer stalls them, another computer may be the only source.
TEST_F(Field, InvalidForeignDataHarmsNoTrack) {
  settings_["field"]["other_computers"] = Json::array({"127.0.0.1"});  // wrongly trusted by an admin
  for (Json& camera : settings_["cameras"]) {
    camera["source"].update(Json{{"speed", 0}, {"frame_rate_hz", 20}});
    camera["calibration"]["focal_length"] = camera["calibration"]["focal_length"].get<double>() / 2;
  }
  RunningDaemon daemon(settings_file(), state_);
  // Until the tracks are established.
  daemon.wait_for_status([](const Json& status) {
    return std::ranges::all_of(status["cameras"], [](const Json& one) { return one["frames"] > 60; });
  });
  wait_for_tracks([](const TrackedFrame& frame) { return frame.robots_size() == 12; });
  MulticastSender stranger({.group = GroupListener::kGroup, .port = listener_.port(), .interface = "lo"});
  std::vector<std::byte> buffer;
  CameraCalibration above;
  above.q0 = 1;
  above.q3 = 0;
  above.tz = 4000;
  above.pixel_image_width = 640;
  above.pixel_image_height = 480;
  // Unused camera ids and one of ours; in two packets, as the number of cameras accepted from one is limited.
  SSL_WrapperPacket packet;
  const auto send_geometry = [&] {
    for (const auto& [first, end] : {std::pair(0U, 32U), std::pair(32U, 60U)}) {
      std::vector<CalibratedCamera> cameras;
      for (std::uint32_t id = first; id < end; ++id) cameras.push_back({id, CameraModel(above)});
      write_geometry({read_config(settings_).field, cameras, {}}, packet);
      stranger.send(serialize(packet, buffer));
    }
  };

  const double nan = std::numeric_limits<double>::quiet_NaN();
  const SimulatedWorld world = simulated_world(read_config(settings_));
  double worst_mm = 0;
  int compared = 0;
  std::map<std::uint32_t, double> looked_s;  // last capture time of each of our cameras
  const auto compare = [&](const TrackedFrame& frame) {
    while (const auto datagram = listener_.receive(1)) {
      SSL_WrapperPacket heard;
      if (!heard.ParseFromString(*datagram) || !heard.has_detection()) continue;
      const SSL_DetectionFrame& image = heard.detection();
      // The foreign images have times that are off by 1e6 s.
      if (std::abs(image.t_capture() - frame.timestamp()) < 1e5)
        looked_s[image.camera_id()] = image.t_capture();
    }
    constexpr double kLately_s = 1;
    if (looked_s.size() < 2 || std::ranges::any_of(looked_s, [&](const auto& camera) {
          return frame.timestamp() - camera.second > kLately_s;
        }))
      return;
    const SimulatedScene truth = world.at(frame.timestamp());
    for (const auto& robot : frame.robots()) {
      const auto one = std::ranges::find_if(truth.robots, [&](const SimulatedRobot& known) {
        return known.id == static_cast<int>(robot.robot_id().id()) &&
               (known.team == Team::kBlue) == (robot.robot_id().team() == BLUE);
      });
      if (one != truth.robots.end() && robot.visibility() >= 0.9) {
        ++compared;
        worst_mm = std::max(
            worst_mm, std::hypot(robot.pos().x() * 1000 - one->x_mm, robot.pos().y() * 1000 - one->y_mm));
      }
    }
  };
  // Foreign cameras are used. Their robots may have no tracks: a busy computer hears of them too late.
  bool are_used = false;
  // Limited by rounds: on a busy computer each takes as long as tracks need to arrive.
  for (std::uint32_t round = 0; round < 400 || compared < 400 * 6 || !are_used; ++round) {
    ASSERT_LT(round, 4000U) << compared << " " << are_used;
    constexpr std::uint32_t kOften = 50;
    if (round % kOften == 0) send_geometry();
    if (!are_used && round % kOften == kOften - 1) {
      are_used = std::ranges::any_of(daemon.get("/api/field").at("other_cameras"),
                                     [](const Json& camera) { return camera.at("is_used") == true; });
    }
    const double now_s = unix_now_s();
    RobotList robots;
    BallList balls;
    // Existing robots in wrong places, robots that do not exist, and some far away.
    for (const SimulatedRobot& one : world.at(now_s).robots) {
      const double off_mm = one.x_mm > 0 ? -1000.0 - round % 2000 : 1000.0 + round % 2000;
      robots.robots.push_back({one.team, one.id, one.x_mm + off_mm, one.y_mm, 0, 140, 0, 0, 0.9});
    }
    for (int i = 0; i < (round % 4 == 0 ? 1000 : 3); ++i) {
      robots.robots.push_back(
          {Team::kBlue, 6 + i % 294, round % 5 == 0 ? 1e7 : 3000.0 - i, 100, 0, 140, 0, 0, 0.9});
    }
    balls.balls.push_back({round % 3 == 0 ? nan : 100, 0, 0, 0, 50, 1});
    const double t_s = now_s + (round % 2 == 0 ? 1e6 : -1e6);
    const std::uint32_t id = round % 7 == 0 ? 0 : 2 + round % 58;  // 0 is ours
    write_detection({.camera_id = id, .number = round, .times = {.t_capture_s = t_s}}, robots, balls,
                    round % 2 == 0 ? t_s : now_s, packet);
    stranger.send(serialize(packet, buffer));
    TrackedFrame tracked;
    do {  // also compares frames that this listener received late
      tracked = receive_tracks().tracked_frame();
      compare(tracked);
    } while (tracked.timestamp() < now_s);
  }
  std::printf("worst: %.0f mm\n", worst_mm);
  EXPECT_LT(worst_mm, 10) << "a robot of ours was dragged away";
  const Json diagnostics = daemon.get("/api/diagnostics").at("field");
  EXPECT_GT(diagnostics.at("sightings_left_out").get<int>() + diagnostics.at("images_off_time").get<int>(),
            0);
}

TEST_F(Field, KeepsItsUuidAcrossRestarts) {
  std::string uuid;
  {
    RunningDaemon daemon(settings_file(), state_);
    uuid = receive_tracks().uuid();
    EXPECT_EQ(uuid.size(), 36U);
  }
  while (tracks_.receive(1)) {  // drop those of the daemon that has ended
  }
  RunningDaemon daemon(settings_file(), state_);
  EXPECT_EQ(receive_tracks().uuid(), uuid);
}

}  // namespace
}  // namespace sslv::test::field_test
