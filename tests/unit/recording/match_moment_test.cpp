// SPDX-License-Identifier: Apache-2.0
#include "recording/match_moment.h"

#include "recording/match_log_writer.h"
#include "ssl_gc_referee_message.pb.h"
#include "ssl_vision_wrapper.pb.h"
#include "ssl_vision_wrapper_tracked.pb.h"
#include "support/temporary_folder.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include <gmock/gmock.h>

namespace sslv {
namespace {

constexpr std::int64_t kBegin_ns = 1'800'000'000'000'000'000;

/// 20 s of two cameras at 10 Hz that see a ball which rolls 100 mm a second, a tracker until 10 s, the game
/// controller once a second; the field is told once, after 2 s.
class MatchMomentTest : public testing::Test {
 protected:
  MatchMomentTest() {
    MatchLogWriter writer(file());
    const auto add = [&](double at_s, std::int32_t type, const std::string& text) {
      writer.add(kBegin_ns + static_cast<std::int64_t>(at_s * 1e9), type, std::as_bytes(std::span(text)));
    };
    for (int i = 0; i <= 200; ++i) {
      const double at_s = i * 0.1;
      for (std::uint32_t camera = 0; camera < 2; ++camera) {
        SSL_WrapperPacket packet;
        auto* frame = packet.mutable_detection();
        frame->set_frame_number(static_cast<std::uint32_t>(i));
        frame->set_t_capture(at_s);
        frame->set_t_sent(at_s);
        frame->set_camera_id(camera);
        auto* ball = frame->add_balls();
        ball->set_confidence(1);
        ball->set_x(static_cast<float>(100 * at_s));
        ball->set_y(static_cast<float>(camera));
        ball->set_pixel_x(0);
        ball->set_pixel_y(0);
        if (i == 20 && camera == 0) {
          auto* size = packet.mutable_geometry()->mutable_field();
          size->set_field_length(9000);
          size->set_field_width(6000);
          size->set_goal_width(1000);
          size->set_goal_depth(180);
          size->set_boundary_width(300);
        }
        if (camera == 0 || i < 100) add(at_s, LoggedMessage::kVision2014, packet.SerializeAsString());
      }
      if (i < 100) {
        TrackerWrapperPacket packet;
        packet.set_uuid("a");
        auto* frame = packet.mutable_tracked_frame();
        frame->set_frame_number(1);
        frame->set_timestamp(at_s);
        auto* robot = frame->add_robots();
        robot->mutable_robot_id()->set_id(4);
        robot->mutable_robot_id()->set_team(::Team::BLUE);
        robot->mutable_pos()->set_x(1.5);
        robot->mutable_pos()->set_y(0);
        robot->set_orientation(1);
        add(at_s + 0.01, LoggedMessage::kTracker2020, packet.SerializeAsString());
      }
      if (i % 10 == 0) {
        Referee referee;
        referee.set_stage(1);
        referee.set_command(i < 100 ? 1 : 3);
        referee.mutable_yellow()->set_name("A");
        referee.mutable_yellow()->set_score(static_cast<std::uint32_t>(i / 100));
        add(at_s + 0.02, LoggedMessage::kReferee, referee.SerializeAsString());
      }
    }
    writer.finish();
  }
  std::filesystem::path file() const { return folder_.path() / "match.log.gz"; }

  test::TemporaryFolder folder_;
};

TEST_F(MatchMomentTest, IsWhatWasKnownThen) {
  MatchMoments moments(file(), std::make_shared<const MatchLogIndex>(match_log_index(file())));
  const Json five = moments.at(5.05);
  ASSERT_EQ(five["cameras"].size(), 2U);
  EXPECT_EQ(five["cameras"][1]["id"], 1);
  EXPECT_NEAR(five["cameras"][1]["time_s"].get<double>(), 5, 1e-6);
  EXPECT_NEAR(five["cameras"][1]["balls"][0]["x"].get<double>(), 500, 1e-3);
  EXPECT_EQ(five["tracked"]["robots"][0]["team"], "blue");
  EXPECT_NEAR(five["tracked"]["robots"][0]["x"].get<double>(), 1500, 1e-3);
  EXPECT_EQ(five["referee"]["command"], "Stop");
  EXPECT_EQ(five["referee"]["yellow"]["score"], 0);
  EXPECT_EQ(five["field"]["length"], 9000);

  const Json fifteen = moments.at(15.05);
  EXPECT_EQ(fifteen["cameras"].size(), 1U) << "the other one has stopped";
  EXPECT_TRUE(fifteen["tracked"].is_null());
  EXPECT_EQ(fifteen["referee"]["command"], "Force start");
  EXPECT_EQ(fifteen["referee"]["yellow"]["score"], 1);
  EXPECT_NEAR(moments.at(5.05)["cameras"][0]["balls"][0]["x"].get<double>(), 500, 1e-3) << "back again";
  EXPECT_NEAR(moments.at(1e9)["time_s"].get<double>(), 20.02, 1e-3) << "kept within the log";
  EXPECT_EQ(moments.at(-1)["time_s"], 0);
}

TEST(DetectionsJson, OfWhatIsNoPacketIsNone) {
  EXPECT_FALSE(detections_json_of({}));
  const std::string text = "\x12\xff\xff";
  EXPECT_FALSE(detections_json_of(std::as_bytes(std::span(text))));
}

}  // namespace
}  // namespace sslv
