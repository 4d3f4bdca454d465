// SPDX-License-Identifier: Apache-2.0
#include "lab/replay.h"

#include "support/live_run.h"
#include "support/temporary_folder.h"

#include <sstream>

#include <gmock/gmock.h>

namespace sslv::replay_test {
namespace {

using testing::HasSubstr;
using testing::Not;

class ReplayClips : public testing::Test {
 protected:
  ReplayClips() {
    LiveRun live(live_settings());
    live.run(0.1);
    live.begin_clip(file_);
    live.run(0.2);
    live.end_clip();
    clip_.emplace(file_);
  }
  const test::TemporaryFolder folder_;
  const std::string file_ = folder_.file("goal.clip");
  std::optional<ClipReader> clip_;
};

TEST_F(ReplayClips, SayThatEveryPacketIsTheLiveOne) {
  std::ostringstream found;
  const auto cameras = replay_cameras(*clip_, {.compares = true, .found = &found});
  ASSERT_EQ(cameras.size(), 2u);
  EXPECT_FALSE(cameras[0].differs);
  EXPECT_EQ(cameras[0].exact, 12u);
  const std::string text = replayed_text(cameras, false);
  EXPECT_THAT(text, HasSubstr("camera 0: 12 frames, exact; 0.2 s in"));
  EXPECT_THAT(text, HasSubstr("every packet is the live one, byte for byte"));
  std::string line;
  std::istringstream lines(found.str());
  ASSERT_TRUE(std::getline(lines, line));
  EXPECT_EQ(Json::parse(line)["frame"], "frame_000006");
  EXPECT_EQ(Json::parse(line)["exact"], true);
}

TEST_F(ReplayClips, SayWhatOtherSettingsChange) {
  Json settings = live_settings();
  for (Json& camera : settings["cameras"]) camera["stages"]["detect_robots"]["min_confidence"] = 1;
  ReplayCommand command{.camera_id = 1, .compares = true};
  command.other = OtherSetup{std::make_shared<const Config>(read_config(settings)), "new.json"};
  const auto cameras = replay_cameras(*clip_, command);
  ASSERT_EQ(cameras.size(), 1u);
  EXPECT_TRUE(cameras[0].differs);
  const Json json = replayed_json(cameras)[0];
  EXPECT_GT(json["comparison"]["robots"]["lost"], 0);
  EXPECT_EQ(json["comparison"]["balls"]["lost"], 0);
  EXPECT_EQ(json["comparison"]["differences"][0]["what"][0]["kind"], "lost");
  const std::string text = replayed_text(cameras, true);
  EXPECT_THAT(text, HasSubstr("camera 1: 12 frames, other settings"));
  EXPECT_THAT(text, HasSubstr(" lost at "));

  // Settings from outside that equal the recorded ones change nothing.
  command.other->settings = std::make_shared<const Config>(read_config(live_settings()));
  EXPECT_FALSE(replay_cameras(*clip_, command)[0].differs);
}

TEST_F(ReplayClips, AreDescribed) {
  const Json info = clip_info_json(file_, *clip_);
  EXPECT_EQ(info["cameras"].size(), 2u);
  EXPECT_EQ(info["cameras"][0]["frames"], 12);
  EXPECT_EQ(info["cameras"][0]["begins"], 1);
  EXPECT_EQ(info["setups"], 2);
  EXPECT_EQ(info["unfinished"], false);
  const std::string text = clip_info_text(info);
  EXPECT_THAT(text, HasSubstr("goal.clip\n  Demo field, begins "));
  EXPECT_THAT(text, HasSubstr("kept: a test"));
  EXPECT_THAT(text, Not(HasSubstr("was not ended")));
}

}  // namespace
}  // namespace sslv::replay_test
