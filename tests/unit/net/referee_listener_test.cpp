// SPDX-License-Identifier: Apache-2.0
#include "net/referee_listener.h"

#include "ssl_gc_referee_message.pb.h"
#include "ssl_vision_wrapper.pb.h"
#include "support/group_listener.h"

#include <gmock/gmock.h>

namespace sslv::referee_listener_test {
namespace {

using boost::asio::ip::udp;
using testing::ElementsAre;
using testing::Optional;

udp::endpoint from(const char* address) {
  return {boost::asio::ip::make_address(address), 40'000};
}

/// A game controller's message, with fields that the vision does not know.
std::string message(const std::string& yellow, const std::string& blue,
                    const std::string& source = "field-1") {
  Referee referee;
  referee.set_stage(1);
  referee.set_command(0);
  referee.mutable_yellow()->set_name(yellow);
  referee.mutable_blue()->set_name(blue);
  referee.mutable_yellow()->set_score(5);
  referee.mutable_yellow()->mutable_unknown_fields()->AddVarint(3, 1);  // red_cards
  referee.mutable_blue()->mutable_unknown_fields()->AddVarint(19, 2);   // hull_color, since 2026
  referee.set_blue_team_on_positive_half(true);
  referee.set_source_identifier(source);
  referee.mutable_unknown_fields()->AddVarint(1, 1'790'000'000'000'000);  // packet_timestamp
  return referee.SerializeAsString();
}

struct Listener {
  int changes = 0;
  RefereeListener referee{[this] { ++changes; }};
  void receive(const std::string& datagram, double now_s = 100, const char* address = "10.0.0.2") {
    referee.receive(std::as_bytes(std::span(datagram)), from(address), now_s);
  }
};

TEST(RefereeListener, HearsTheNamesOfTheTeams) {
  Listener listener;
  EXPECT_THAT(listener.referee.team_names(), ElementsAre("", ""));
  EXPECT_EQ(listener.referee.status(100).silent_s, std::nullopt);
  listener.receive(message("TIGERs Mannheim", "CMμs"));
  EXPECT_THAT(listener.referee.team_names(), ElementsAre("TIGERs Mannheim", "CMμs"));
  const RefereeStatus status = listener.referee.status(102);
  EXPECT_THAT(status.silent_s, Optional(2.0));
  EXPECT_EQ(status.followed.source, "field-1");
  EXPECT_EQ(status.followed.address, "10.0.0.2");
  EXPECT_FALSE(status.other);
  EXPECT_EQ(status.refused, 0U);
}

TEST(RefereeListener, ATeamThatIsNotChosenYetHasNoName) {
  Listener listener;
  listener.receive(message("Unknown", "KIKS"));
  EXPECT_THAT(listener.referee.team_names(), ElementsAre("", "KIKS"));
}

TEST(RefereeListener, RemovesControlCharactersFromNames) {
  Listener listener;
  listener.receive(message("MRL\u202e\x1b[2J", "KI\u0085KS\n", "\u2066field"));
  EXPECT_THAT(listener.referee.team_names(), ElementsAre("MRL[2J", "KIKS"));
  EXPECT_EQ(listener.referee.status(100).followed.source, "field");
}

TEST(RefereeListener, NotifiesOnlyIfANameChanges) {
  Listener listener;
  for (int i = 0; i < 3; ++i) listener.receive(message("MRL", "KIKS"));
  EXPECT_EQ(listener.changes, 1);
  listener.receive(message("MRL", "ibis"));
  EXPECT_EQ(listener.changes, 2);
  listener.receive(message("", ""));
  EXPECT_EQ(listener.changes, 3);
}

TEST(RefereeListener, FollowsTheFirstOfTwoUntilItIsSilent) {
  Listener listener;
  const auto other = [&](double now_s) {
    const auto seen = listener.referee.status(now_s).other;
    return seen ? seen->source + " at " + seen->address : "none";
  };
  for (double now_s = 100; now_s < 110; ++now_s) {
    listener.receive(message("MRL", "KIKS"), now_s);
    listener.receive(message("KIKS", "MRL", "field-2"), now_s + 0.5, "10.0.0.3");
  }
  EXPECT_THAT(listener.referee.team_names(), ElementsAre("MRL", "KIKS"));
  EXPECT_EQ(listener.changes, 1);
  EXPECT_EQ(listener.referee.status(110).followed.source, "field-1");
  EXPECT_THAT(listener.referee.status(110).silent_s, Optional(1.0));
  EXPECT_EQ(listener.referee.status(110).refused, 0U);
  EXPECT_EQ(other(110), "field-2 at 10.0.0.3");
  EXPECT_EQ(other(115), "none") << "it has been silent for longer than 5 s";
  // The first source was last heard at 109 s.
  listener.receive(message("KIKS", "MRL", "field-2"), 114, "10.0.0.3");
  EXPECT_EQ(listener.changes, 1);
  listener.receive(message("KIKS", "MRL", "field-2"), 114.5, "10.0.0.3");
  EXPECT_EQ(listener.changes, 2);
  EXPECT_THAT(listener.referee.team_names(), ElementsAre("KIKS", "MRL"));
  EXPECT_EQ(listener.referee.status(115).followed.source, "field-2");
  EXPECT_EQ(other(115), "none");
  listener.receive(message("MRL", "KIKS"), 115);
  EXPECT_EQ(listener.changes, 2) << "it comes back, and is the second now";
  EXPECT_EQ(other(115), "field-1 at 10.0.0.2");
}

TEST(RefereeListener, OneGameControllerMaySendFromSeveralAddresses) {
  Listener listener;
  listener.receive(message("MRL", "KIKS"));
  listener.receive(message("MRL", "ibis"), 100, "10.0.1.2");
  EXPECT_THAT(listener.referee.team_names(), ElementsAre("MRL", "ibis"));
  EXPECT_FALSE(listener.referee.status(100).other);
}

TEST(RefereeListener, GameControllersWithoutNamesAreToldApartByTheirAddresses) {
  Listener listener;
  listener.receive(message("MRL", "KIKS", ""));
  listener.receive(message("KIKS", "MRL", ""), 100, "10.0.0.3");
  EXPECT_THAT(listener.referee.team_names(), ElementsAre("MRL", "KIKS"));
  EXPECT_EQ(listener.referee.status(100).followed.source, "10.0.0.2");
  EXPECT_EQ(listener.referee.status(100).other->source, "10.0.0.3");
}

TEST(RefereeListener, ReadsTheBytesOfTheWire) {
  // Encoded by hand: the tag of a length-delimited field is (field << 3 | 2).
  Listener listener;
  listener.receive("\x10\x01\x20\x02\x3A\x05\x0A\x03MRL\x42\x06\x0A\x04KIKS\x50\x01\x92\x01\x02gc");
  EXPECT_THAT(listener.referee.team_names(), ElementsAre("MRL", "KIKS"));
  EXPECT_EQ(listener.referee.status(100).followed.source, "gc");
}

TEST(RefereeListener, InvalidMessagesAreOnlyCounted) {
  Listener listener;
  listener.receive(message("MRL", "KIKS"));
  SSL_WrapperPacket vision;
  vision.mutable_detection()->set_frame_number(1);
  const std::vector<std::string> refused{"",
                                         "garbage",
                                         std::string(65'507, '\xFF'),
                                         std::string(65'507, '\0'),
                                         message("MRL", "ibis").substr(0, 9),
                                         message("\xFF\xFE", "ibis"),
                                         message(std::string(201, 'x'), "ibis"),
                                         vision.SerializePartialAsString()};
  testing::internal::CaptureStderr();
  for (const std::string& datagram : refused) listener.receive(datagram, 200);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "strangers do not fill the log";
  EXPECT_THAT(listener.referee.team_names(), ElementsAre("MRL", "KIKS"));
  EXPECT_EQ(listener.changes, 1);
  EXPECT_EQ(listener.referee.status(200).refused, refused.size());
  EXPECT_THAT(listener.referee.status(200).silent_s, Optional(100.0));
}

TEST(RefereeListener, KnowsWhetherTheGameRuns) {
  const auto says = [](int stage, int command) {
    Referee referee;
    referee.ParseFromString(message("MRL", "KIKS"));
    referee.set_stage(stage);
    referee.set_command(command);
    return referee.SerializeAsString();
  };
  constexpr int kHalt = 0, kStop = 1, kForceStart = 3;
  Listener listener;
  EXPECT_FALSE(listener.referee.game_is_running());
  for (const int playing : {1, 4, 7, 10, 12}) {
    for (const int command : {kStop, kForceStart}) {
      listener.receive(says(playing, command));
      EXPECT_TRUE(listener.referee.game_is_running()) << playing;
      EXPECT_TRUE(listener.referee.status(100).game_is_running);
    }
    listener.receive(says(playing, kHalt));
    EXPECT_FALSE(listener.referee.game_is_running()) << playing;
  }
  for (const int pausing : {0, 2, 3, 5, 6, 8, 9, 11, 13}) {
    listener.receive(says(1, kForceStart));
    listener.receive(says(pausing, kStop));
    EXPECT_FALSE(listener.referee.game_is_running()) << pausing;
  }
  listener.receive(says(1, kForceStart));
  listener.receive("garbage");
  EXPECT_TRUE(listener.referee.game_is_running());
  listener.receive(
      "\x3A\x05\x0A\x03MRL\x42\x06\x0A\x04KIKS\x92\x01\x07"
      "field-1");  // neither stage nor command
  EXPECT_FALSE(listener.referee.game_is_running());
}

TEST(RefereeListener, AHaltIsPartOfTheStage) {
  Listener listener;
  EXPECT_FALSE(listener.referee.status(100).stage_is_played);
  listener.receive(message("MRL", "KIKS"));  // the first half, HALT
  EXPECT_TRUE(listener.referee.status(100).stage_is_played);
}

TEST(RefereeListener, AMatchLastsFromItsFirstHalfToItsEndWithAllBreaks) {
  Listener listener;
  EXPECT_FALSE(listener.referee.status(100).is_in_match());
  Referee referee;
  referee.ParseFromString(message("MRL", "KIKS"));
  for (int stage = 0; stage <= 13; ++stage) {
    referee.set_stage(stage);
    listener.receive(referee.SerializeAsString());
    EXPECT_EQ(listener.referee.status(100).is_in_match(), stage != 0 && stage != 13) << stage;
    const bool half_is_next = stage == 0 || stage == 3 || stage == 6 || stage == 9;
    EXPECT_EQ(listener.referee.status(100).half_is_next(), half_is_next) << stage;
  }
  listener.receive(message("MRL", "KIKS"));
  EXPECT_TRUE(listener.referee.status(100).match_runs());
  EXPECT_FALSE(listener.referee.status(1000).match_runs()) << "the game controller is off";
  EXPECT_FALSE(listener.referee.status(1000).is_in_match());
}

TEST(RefereeListener, KnowsWhenRobotsMayBeTakenOff) {
  Listener listener;
  Referee referee;
  referee.ParseFromString(message("MRL", "KIKS"));
  for (int command = 0; command <= 17; ++command) {
    referee.set_command(command);
    listener.receive(referee.SerializeAsString());
    const bool is_halt_or_timeout = command == 0 || command == 12 || command == 13;
    EXPECT_EQ(listener.referee.status(100).robots_are_handled, is_halt_or_timeout) << command;
  }
}

TEST(RefereeListener, HearsHowManyRobotsMayPlay) {
  const auto allows = [](int yellow, int blue) {
    Referee referee;
    referee.ParseFromString(message("MRL", "KIKS"));
    referee.mutable_yellow()->set_max_allowed_bots(static_cast<std::uint32_t>(yellow));
    referee.mutable_blue()->set_max_allowed_bots(static_cast<std::uint32_t>(blue));
    return referee.SerializeAsString();
  };
  Listener listener;
  listener.receive(message("MRL", "KIKS"));
  EXPECT_THAT(listener.referee.status(100).robots_allowed, ElementsAre(std::nullopt, std::nullopt));
  listener.receive(allows(11, 10));
  EXPECT_THAT(listener.referee.status(100).robots_allowed, ElementsAre(Optional(11), Optional(10)));
  listener.receive(allows(0, 4'000'000));
  EXPECT_THAT(listener.referee.status(100).robots_allowed, ElementsAre(Optional(0), std::nullopt));
}

TEST(RefereeListener, HearsTheTeamsHalves) {
  Listener listener;
  EXPECT_EQ(listener.referee.status(100).blue_at_positive_x, std::nullopt);
  listener.receive(message("MRL", "KIKS"));
  EXPECT_THAT(listener.referee.status(100).blue_at_positive_x, Optional(true));
  Referee referee;
  referee.ParseFromString(message("MRL", "KIKS"));
  referee.set_blue_team_on_positive_half(false);
  listener.receive(referee.SerializeAsString());
  EXPECT_THAT(listener.referee.status(100).blue_at_positive_x, Optional(false));
  referee.clear_blue_team_on_positive_half();
  listener.receive(referee.SerializeAsString());
  EXPECT_EQ(listener.referee.status(100).blue_at_positive_x, std::nullopt);
}

TEST(RefereeListener, KnowsStageTimeAndScore) {
  Listener listener;
  EXPECT_FALSE(listener.referee.status(100).match);
  Referee referee;
  referee.ParseFromString(message("MRL", "KIKS"));
  referee.set_stage(4);
  referee.set_stage_time_left(-1'500'000);
  referee.mutable_blue()->set_score(3);
  listener.receive(referee.SerializeAsString());
  const std::optional<MatchState> match = listener.referee.status(100).match;
  ASSERT_TRUE(match);
  EXPECT_EQ(match->stage, 4);
  EXPECT_THAT(match->time_left_s, Optional(-1.5));
  EXPECT_THAT(match->score, ElementsAre(5U, 3U));
  referee.clear_stage_time_left();
  listener.receive(referee.SerializeAsString());
  EXPECT_EQ(listener.referee.status(100).match->time_left_s, std::nullopt);
  referee.clear_stage();
  listener.receive(referee.SerializeAsString());
  EXPECT_FALSE(listener.referee.status(100).match);
}

TEST(RefereeListener, ForgetsTheNamesWhenItListensElsewhere) {
  GroupListener group;
  Listener listener;
  const GroupAddress where{GroupListener::kGroup, group.port(), "lo"};
  listener.referee.listen(where);
  listener.receive(message("MRL", "KIKS"));
  listener.referee.listen(where);
  EXPECT_THAT(listener.referee.team_names(), ElementsAre("MRL", "KIKS"));
  listener.referee.listen(std::nullopt);
  EXPECT_THAT(listener.referee.team_names(), ElementsAre("", ""));
}

}  // namespace
}  // namespace sslv::referee_listener_test
